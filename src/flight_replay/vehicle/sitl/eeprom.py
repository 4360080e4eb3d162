"""Sets each parameter of a simulator that is too old for parameter files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from flight_replay.vehicle import connect
from flight_replay.vehicle.sitl.bench_parameters import bench_parameters


def store_bench_parameters(connection: str, defaults: Path | None) -> None:
    """Set the parameters with which the simulated vehicle can be armed; valid from the next boot on.

    Args:
        connection: The simulator's connection string.
        defaults: A parameter file to use instead of ``bench_parameters``.

    Raises:
        VehicleError: The simulator does not accept a value.
    """
    wanted = dict(_parameters_of(defaults) if defaults else bench_parameters())
    with connect(connection) as vehicle:
        vehicle.set_known_parameters(wanted)


def _parameters_of(path: Path) -> Iterator[tuple[str, float]]:
    """Names and values of a parameter file: pairs separated by blanks, commas or tabs; ``#`` comments."""
    for line in path.read_text().splitlines():
        fields = line.partition("#")[0].replace(",", " ").split()
        if len(fields) >= 2:
            yield fields[0], float(fields[1])

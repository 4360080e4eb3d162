"""Fills the storage of a simulator too old for parameter files, by telling it each parameter."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from flight_replay.vehicle import connect
from flight_replay.vehicle.sitl.bench_parameters import bench_parameters


def store_bench_parameters(connection: str, defaults: Path | None) -> None:
    """Set what makes the simulated vehicle fit to fly; it counts from the next boot on.

    Args:
        connection: The simulator's connection string.
        defaults: A parameter file to use in place of the built-in ones.

    Raises:
        VehicleError: The simulator does not take them.
    """
    wanted = dict(_parameters_of(defaults) if defaults else bench_parameters())
    with connect(connection) as vehicle:
        vehicle.set_known_parameters(wanted)


def _parameters_of(path: Path) -> Iterator[tuple[str, float]]:
    """Names and values of a parameter file: pairs between blanks, commas or tabs, ``#`` comments."""
    for line in path.read_text().splitlines():
        fields = line.partition("#")[0].replace(",", " ").split()
        if len(fields) >= 2:
            yield fields[0], float(fields[1])

"""Sets each parameter of a simulator that is too old for parameter files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path

from flight_replay.exceptions import SimulatorError
from flight_replay.vehicle import connect
from flight_replay.vehicle.sitl.bench_parameters import bench_parameters


def store_bench_parameters(connection: str, defaults: Sequence[Path]) -> None:
    """Set the parameters with which the simulated vehicle can be armed; valid from the next boot on.

    Args:
        connection: The simulator's connection string.
        defaults: Parameter files to use instead of ``bench_parameters``.

    Raises:
        VehicleError: The simulator does not accept a value.
        SimulatorError: A parameter file cannot be read.
    """
    wanted = dict(chain.from_iterable(map(_parameters_of, defaults)) if defaults else bench_parameters())
    with connect(connection) as vehicle:
        vehicle.set_known_parameters(wanted)


def _parameters_of(path: Path) -> Iterator[tuple[str, float]]:
    """Names and values of a parameter file: pairs separated by blanks, commas or tabs; ``#`` comments."""
    try:
        for line in path.read_text().splitlines():
            fields = line.partition("#")[0].replace(",", " ").split()
            if len(fields) >= 2:
                yield fields[0], float(fields[1])
    except (OSError, ValueError) as error:
        raise SimulatorError(f"cannot read the parameter file {path}: {error}; correct it") from error

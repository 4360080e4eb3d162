"""Parameters that are changed for a flight are kept in a file until they are put back.

A program that is killed cannot put them back: the file then stays, and the next replay tells of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING

from flight_replay.events import Listener, Notice
from flight_replay.exceptions import FlightReplayError
from flight_replay.writing.output_files import unused_path, write_atomically

if TYPE_CHECKING:
    from flight_replay.vehicle import ConnectedVehicle

SUFFIXES = (".parm", ".param")
_NAME = "parameters-before-"
_SAME = 1e-4  # Relative: parameters are float32.
Command = Callable[[Path], str]
"""Gives the shell command that puts the parameters in a file back."""


@contextmanager
def kept_parameters(
    connected: ConnectedVehicle,
    wanted: Mapping[str, float],
    folder: Path,
    command: Command,
    listener: Listener,
) -> Iterator[None]:
    """Set parameters for as long as the context lasts; a file has those before until they are put back.

    Args:
        connected: the vehicle.
        wanted: parameters in its own units.
        folder: where the file is.
        command: for people, where not all are put back.
        listener: gets a notice of those.

    Raises:
        VehicleError: The vehicle is armed, has no such parameter, or does not accept or restore a value.
        FlightReplayError: The file cannot be written.
    """
    before = connected.parameters(wanted)
    changed = {name: value for name, value in wanted.items() if not _is_same(before.get(name), value)}
    if not changed:
        yield
        return
    path = unused_path(folder / f"{_NAME}{datetime.now():%Y%m%d-%H%M%S}{SUFFIXES[0]}")
    left = set(changed)
    # Refuses an armed vehicle: no file of it.
    change = connected.parameters_set(changed, left.intersection_update)
    write_atomically(path, parameter_text({name: before[name] for name in changed if name in before}))
    try:
        with change:
            yield
    finally:
        if left:
            listener(Notice(_not_put_back(sorted(left), command(path)), warning=True))
        else:
            _discard(path)


def _discard(path: Path) -> None:
    """Delete a file that is not needed any more: one that stays does no harm to the flight."""
    with suppress(OSError):
        path.unlink(missing_ok=True)


def _not_put_back(names: Iterable[str], command: str) -> str:
    return f"{', '.join(names)} may not be as before the flight; to put back what was, run: {command}"


def tell_of_changed_parameters(
    connected: ConnectedVehicle, folder: Path, command: Command, listener: Listener
) -> None:
    """Tell of parameters that a replay which was killed has left changed, by the latest file in a folder."""
    files = sorted(path for path in folder.glob(f"{_NAME}*") if path.suffix in SUFFIXES)
    if not files:
        return
    try:
        before = read_parameter_file(files[-1])
    except FlightReplayError as error:
        listener(Notice(f"{error}, or delete it: a replay kept parameters there", warning=True))
        return
    now = connected.parameters(before)
    changed = {
        name: value for name, value in before.items() if name in now and not _is_same(now[name], value)
    }
    if changed:
        values = ", ".join(f"{name} {now[name]:g} instead of {value:g}" for name, value in changed.items())
        listener(
            Notice(
                f"an earlier replay from this folder did not put parameters back ({values}); "
                f"if they are this vehicle's, run: {command(files[-1])}",
                warning=True,
            )
        )


def parameter_text(parameters: Mapping[str, float]) -> str:
    """A file of parameters as ground stations read it: a name and a value a line."""
    return "".join(f"{name} {value:.9g}\n" for name, value in parameters.items())


def read_parameter_file(path: Path) -> dict[str, float]:
    """Parameters by name, in the vehicle's own units; lines that begin with # are comments.

    Raises:
        FlightReplayError: The file cannot be read, or a line is not a name and a number.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FlightReplayError(f"cannot read {path}: {error}; choose another file") from error
    parameters = {}
    for number, line in enumerate(lines, 1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            name, value = words
            parameters[name] = float(value)
        except ValueError as error:
            raise FlightReplayError(
                f"{path}, line {number}: not a name and a number: {line.strip()!r}; correct it"
            ) from error
    return parameters


def _is_same(now: float | None, value: float) -> bool:
    return now is not None and isclose(now, value, rel_tol=_SAME, abs_tol=_SAME)

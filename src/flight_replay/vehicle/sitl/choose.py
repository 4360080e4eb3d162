"""The simulator for a replay: ArduPilot's where one is at hand, else the built-in copter."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from flight_replay.errors import SimulatorError
from flight_replay.events import Listener, Notice, ignore
from flight_replay.simulator.autopilot.location import Start
from flight_replay.vehicle.sitl import process
from flight_replay.vehicle.sitl.download import Source, download, dronekit_sitl_source
from flight_replay.vehicle.sitl.locate import Binary, at_hand


@contextmanager
def simulator(
    kind: str, path: Path | None, start: Start, *, speedup: float = 1.0, listener: Listener = ignore
) -> Iterator[str]:
    """Run a simulator for as long as the context lasts; its connection string.

    Args:
        kind: "auto", "sitl" or "builtin".
        path: An ArduPilot SITL binary, or None to look for one.
        start: Where the copter stands.
        speedup: Vehicle seconds per second.
        listener: Hears which simulator it is where that was not asked for, and of a download.

    Raises:
        SimulatorError: No simulator of that kind can be had or started, or the one named fails.
    """
    with ExitStack() as stack:
        if kind == "sitl" or path is not None:
            running = stack.enter_context(process.run(_binary(path, listener), start, speedup=speedup))
            yield running.connection
            return
        if kind == "auto" and (connection := _auto(stack, start, speedup, listener)) is not None:
            yield connection
            return
        from flight_replay.simulator.server import launch

        yield stack.enter_context(launch.run(start, speedup=speedup)).connection


def _auto(stack: ExitStack, start: Start, speedup: float, listener: Listener) -> str | None:
    """ArduPilot's simulator, unless only one that the user did not name fails."""
    source, missing = _source()
    binary = at_hand(None, source)
    try:
        binary = binary or _downloaded(source, missing, listener)
        return stack.enter_context(process.run(binary, start, speedup=speedup)).connection
    except SimulatorError as error:
        if binary is not None and binary.named:
            raise
        listener(Notice(f"Flying the built-in copter: {error}"))
        return None


def _binary(path: Path | None, listener: Listener) -> Binary:
    """The binary to run, downloaded if there is no other."""
    source, missing = _source()
    return at_hand(path, source) or _downloaded(source, missing, listener)


def _source() -> tuple[Source | None, SimulatorError | None]:
    """Where dronekit-sitl's binaries are, or why there are none."""
    try:
        return dronekit_sitl_source(), None
    except SimulatorError as error:
        return None, error


def _downloaded(source: Source | None, missing: SimulatorError | None, listener: Listener) -> Binary:
    if source is None:
        raise missing or SimulatorError("no ArduPilot SITL is at hand; name one with --sitl")
    return Binary(download(source, listener))

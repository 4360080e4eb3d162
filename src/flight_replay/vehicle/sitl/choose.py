"""Chooses the simulator of a replay: ArduPilot SITL if one is found, else the built-in copter."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from flight_replay.events import Listener, Notice, ignore
from flight_replay.exceptions import SimulatorError
from flight_replay.simulator.autopilot.location import Start
from flight_replay.vehicle.sitl import process
from flight_replay.vehicle.sitl.download import DownloadSource, download, dronekit_sitl_source
from flight_replay.vehicle.sitl.locate import SitlBinary, find_binary

# As DroneKit's example says it.
_STARTING_SITL = "Starting copter simulator (SITL)"
_STARTING_BUILTIN = "Starting copter simulator (built-in copter{})"
_NO_SITL = "; --sim sitl downloads ArduPilot's"


@contextmanager
def simulator(
    kind: str, path: Path | None, start: Start, *, speedup: float = 1.0, listener: Listener = ignore
) -> Iterator[str]:
    """Run a simulator for as long as the context lasts; yields its connection string.

    Args:
        kind: "auto", "sitl" or "builtin"; only "sitl" downloads ArduPilot SITL if none is found.
        path: An ArduPilot SITL binary, or None to search for one.
        start: The copter's position and heading.
        speedup: How fast the vehicle's clock runs.
        listener: Gets the progress of a download, and which simulator starts.

    Raises:
        SimulatorError: No simulator of that kind can be found or started, or the one named fails.
    """
    with ExitStack() as stack:
        if kind == "sitl" or path is not None:
            binary = _binary(path, listener)
            listener(Notice(_STARTING_SITL))
            running = stack.enter_context(process.run(binary, start, speedup=speedup, listener=listener))
            yield running.connection
            return
        if kind == "auto" and (connection := _start_auto(stack, start, speedup, listener)) is not None:
            yield connection
            return
        if kind == "builtin":
            listener(Notice(_STARTING_BUILTIN.format("")))
        from flight_replay.simulator.server import launch

        yield stack.enter_context(launch.run(start, speedup=speedup)).connection


def _start_auto(stack: ExitStack, start: Start, speedup: float, listener: Listener) -> str | None:
    """The connection string of an ArduPilot SITL on this machine; None without one that can fly.

    Raises:
        SimulatorError: The binary that the user named fails.
    """
    binary = find_binary(None, _download_source())
    if binary is None:
        listener(Notice(_STARTING_BUILTIN.format(_NO_SITL)))
        return None
    listener(Notice(_STARTING_SITL))
    try:
        return stack.enter_context(process.run(binary, start, speedup=speedup, listener=listener)).connection
    except SimulatorError as error:
        if binary.named:
            raise
        listener(Notice(f" {error}"))
        listener(Notice(_STARTING_BUILTIN.format("")))
        return None


def _binary(path: Path | None, listener: Listener) -> SitlBinary:
    """The binary to run, downloaded if none is found."""
    found = find_binary(path, _download_source())
    return found or SitlBinary(download(dronekit_sitl_source(), listener))


def _download_source() -> DownloadSource | None:
    """Where dronekit-sitl stores its binaries; None if it has none for this machine."""
    try:
        return dronekit_sitl_source()
    except SimulatorError:
        return None

"""Reads a recorded flight, whatever the format of its log."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from flight_replay.exceptions import LogError
from flight_replay.logs.byte_source import OpenLog, Progress, open_log
from flight_replay.logs.log_formats import LogFormat, recognised
from flight_replay.logs.recording import Recording
from flight_replay.logs.vehicles import VehicleId

_ENDS_EARLY = "Its gzip data is damaged or cut off: the rest of the log cannot be read"


def read_log(
    path: Path | str,
    *,
    vehicle: VehicleId | None = None,
    progress: Progress | None = None,
    opened: Callable[[LogFormat], None] | None = None,
) -> Recording:
    """Read the usable fixes of a vehicle, by default the one that has most.

    Args:
        path: A log of any format, plain or packed with gzip, or ``-`` for standard input.
        vehicle: The vehicle to read; a system id alone means its component with most fixes.
        progress: Told the stored bytes read so far, and their number (0 where unknown).
        opened: Told the log's format before it is read.

    Raises:
        LogError: There is no such log, or nothing usable in it.
    """
    with open_log(path) as log:
        return read_open_log(log, vehicle=vehicle, progress=progress, opened=opened)


def read_open_log(
    log: OpenLog,
    *,
    vehicle: VehicleId | None = None,
    progress: Progress | None = None,
    opened: Callable[[LogFormat], None] | None = None,
) -> Recording:
    """Read a log that is open, from wherever its bytes come; arguments and errors as for ``read_log``."""
    kind = recognised(log)
    if opened:
        opened(kind)
    recording = replace(kind.read(log, vehicle, progress), format=kind.name)
    if log.ends_early:
        recording = replace(recording, notes=(*recording.notes, _ENDS_EARLY))
    if vehicle is not None:
        _check_vehicle(recording, vehicle)
    return recording


def _check_vehicle(recording: Recording, wanted: VehicleId) -> None:
    """Refuse a recording of another vehicle; formats that hold one vehicle need not look."""
    if recording.vehicle is None:
        raise LogError(f"{recording.path} does not name its vehicle; leave out --vehicle")
    if not recording.vehicle.is_named(wanted):
        raise LogError(f"{recording.path} has positions of vehicle {recording.vehicle.id} only, not {wanted}")

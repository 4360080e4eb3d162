"""The flight records of DJI's apps (DJIFlightRecord_....txt), which are encrypted since version 13."""

from __future__ import annotations

from flight_replay.exceptions import LogError
from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.recording import Recording
from flight_replay.logs.vehicles import VehicleId

_FIRST_ENCRYPTED = 13


def read_dji_record(log: OpenLog, _vehicle: VehicleId | None, _progress: Progress | None) -> Recording:
    """Refuse a flight record, and say what to do.

    Raises:
        LogError: Always.
    """
    version = log.head[10]
    how = "encrypted by DJI" if version >= _FIRST_ENCRYPTED else "not read here"
    raise LogError(
        f"{log.name} is a DJI flight record of version {version}, {how}; upload it to airdata.com, "
        "download the flight as CSV, and name that"
    )

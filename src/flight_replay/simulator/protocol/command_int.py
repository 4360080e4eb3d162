"""A MAVLink command, and the results that answer one."""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.mavlink import dialect

ACCEPTED: int = dialect.MAV_RESULT_ACCEPTED
TEMPORARILY_REJECTED: int = dialect.MAV_RESULT_TEMPORARILY_REJECTED
DENIED: int = dialect.MAV_RESULT_DENIED
UNSUPPORTED: int = dialect.MAV_RESULT_UNSUPPORTED
FAILED: int = dialect.MAV_RESULT_FAILED


@dataclass(frozen=True, slots=True)
class CommandInt:
    """A COMMAND_INT, or a COMMAND_LONG as one: degrees times 1e7, and metres in ``frame``."""

    number: int
    params: tuple[float, float, float, float]
    x: int
    y: int
    z: float
    frame: int

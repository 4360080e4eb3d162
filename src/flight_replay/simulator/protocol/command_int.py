"""A MAVLink command, what runs one, and the results that answer it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.protocol.channel import Sender

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


CommandHandler = Callable[[Autopilot, CommandInt, Sender], int]
"""Runs a command of a sender; what it returns is a MAV_RESULT."""

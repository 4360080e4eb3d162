"""A MAVLink command, COMMAND_LONG or COMMAND_INT."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    """A command in either form: degrees times 1e7 where it has a place, metres in ``frame``."""

    number: int
    params: tuple[float, float, float, float]
    x: int
    y: int
    z: float
    frame: int

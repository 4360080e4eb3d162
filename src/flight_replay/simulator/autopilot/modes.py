"""ArduCopter's flight modes: their numbers, names and what each needs (mode.h, mode.cpp)."""

from __future__ import annotations

from enum import IntEnum


class Mode(IntEnum):
    """Mode numbers, which are HEARTBEAT.custom_mode."""

    STABILIZE = 0
    ACRO = 1
    ALT_HOLD = 2
    AUTO = 3
    GUIDED = 4
    LOITER = 5
    RTL = 6
    LAND = 9
    POSHOLD = 16
    BRAKE = 17


NEEDS_POSITION = frozenset({Mode.AUTO, Mode.GUIDED, Mode.LOITER, Mode.RTL, Mode.POSHOLD, Mode.BRAKE})
MANUAL_THROTTLE = frozenset({Mode.STABILIZE, Mode.ACRO})
NO_ARMING = frozenset({Mode.RTL, Mode.LAND, Mode.BRAKE})
"""Modes in which arming is refused; AUTO is decided by AUTO_OPTIONS."""
USER_TAKEOFF = frozenset({Mode.ALT_HOLD, Mode.LOITER, Mode.POSHOLD, Mode.GUIDED})
"""Modes in which NAV_TAKEOFF as a command lifts off."""
GUIDED_FLAG = frozenset({Mode.AUTO, Mode.RTL, Mode.LOITER, Mode.GUIDED, Mode.POSHOLD, Mode.BRAKE})
"""Modes that show MAV_MODE_FLAG_GUIDED_ENABLED in the heartbeat."""

_BLOCK_BITS = {
    Mode.STABILIZE: 0, Mode.ACRO: 1, Mode.ALT_HOLD: 2, Mode.AUTO: 3, Mode.GUIDED: 4, Mode.LOITER: 5,
    Mode.POSHOLD: 11, Mode.BRAKE: 12,
}  # fmt: skip


def is_blocked(mode: Mode, blocked: int) -> bool:
    """Whether FLTMODE_GCSBLOCK keeps ground stations from entering a mode."""
    bit = _BLOCK_BITS.get(mode)
    return bit is not None and bool(blocked >> bit & 1)

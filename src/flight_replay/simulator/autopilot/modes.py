"""What ArduCopter's flight modes need and allow (mode.h, mode.cpp), and which of them are simulated."""

from __future__ import annotations

from flight_replay.flight_modes import CopterMode

SIMULATED = frozenset(
    {
        CopterMode.STABILIZE,
        CopterMode.ACRO,
        CopterMode.ALT_HOLD,
        CopterMode.AUTO,
        CopterMode.GUIDED,
        CopterMode.LOITER,
        CopterMode.RTL,
        CopterMode.LAND,
        CopterMode.POSHOLD,
        CopterMode.BRAKE,
    }
)
"""Modes that the built-in copter has; of the manual ones, only that they can be entered."""
NEEDS_POSITION = frozenset(
    {
        CopterMode.AUTO,
        CopterMode.GUIDED,
        CopterMode.LOITER,
        CopterMode.RTL,
        CopterMode.POSHOLD,
        CopterMode.BRAKE,
    }
)
"""Modes that are entered armed only with a position estimate."""
GUIDED_FLAG = NEEDS_POSITION
"""Modes that show MAV_MODE_FLAG_GUIDED_ENABLED in the heartbeat."""
MANUAL_THROTTLE = frozenset({CopterMode.STABILIZE, CopterMode.ACRO})
NO_ARMING = frozenset({CopterMode.RTL, CopterMode.LAND, CopterMode.BRAKE})
"""Modes in which arming is refused; AUTO is decided by AUTO_OPTIONS."""
USER_TAKEOFF = frozenset({CopterMode.ALT_HOLD, CopterMode.LOITER, CopterMode.POSHOLD, CopterMode.GUIDED})
"""Modes in which NAV_TAKEOFF as a command lifts off."""

_BLOCK_BITS = {
    CopterMode.STABILIZE: 0,
    CopterMode.ACRO: 1,
    CopterMode.ALT_HOLD: 2,
    CopterMode.AUTO: 3,
    CopterMode.GUIDED: 4,
    CopterMode.LOITER: 5,
    CopterMode.POSHOLD: 11,
    CopterMode.BRAKE: 12,
}


def is_blocked(mode: CopterMode, blocked: int) -> bool:
    """Whether FLTMODE_GCSBLOCK keeps ground stations from entering a mode."""
    bit = _BLOCK_BITS.get(mode)
    return bit is not None and bool(blocked >> bit & 1)

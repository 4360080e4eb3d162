"""ArduCopter's flight modes by number, as in HEARTBEAT.custom_mode (Mode::Number in ArduCopter/mode.h)."""

from __future__ import annotations

from enum import IntEnum


class CopterMode(IntEnum):
    """Every flight mode of ArduCopter up to 4.7."""

    STABILIZE = 0
    ACRO = 1
    ALT_HOLD = 2
    AUTO = 3
    GUIDED = 4
    LOITER = 5
    RTL = 6
    CIRCLE = 7
    LAND = 9
    DRIFT = 11
    SPORT = 13
    FLIP = 14
    AUTOTUNE = 15
    POSHOLD = 16
    BRAKE = 17
    THROW = 18
    AVOID_ADSB = 19
    GUIDED_NOGPS = 20
    SMART_RTL = 21
    FLOWHOLD = 22
    FOLLOW = 23
    ZIGZAG = 24
    SYSTEMID = 25
    AUTOROTATE = 26
    AUTO_RTL = 27
    TURTLE = 28


def mode_name(number: int) -> str:
    """The mode's name; a mode newer than this list goes by its number."""
    try:
        return CopterMode(number).name
    except ValueError:
        return f"mode {number}"


def mode_number(name: str) -> int:
    """The number of a mode.

    Raises:
        KeyError: ArduCopter has no such mode.
    """
    return CopterMode[name].value

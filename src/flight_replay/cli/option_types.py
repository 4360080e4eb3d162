"""Parsers of option values: each function turns the text of a value into the value."""

from __future__ import annotations

import argparse
import math

from flight_replay.planning.altitude import RECORDED, Recorded

_MAX_DIGITS = 18
_MAX_QUOTED = 40
_MAX_POINTS = 32_000
_MAX_BAUD = 10_000_000
_MIN_SPEEDUP, _MAX_SPEEDUP = 0.01, 1_000
_MAX_HEIGHT_M = 80_000  # ArduPilot stores centimetres in 24 bits (AP_Mission).
_MIN_SPEED_M_S, _MAX_SPEED_M_S = 0.2, 300  # ArduCopter ignores less, and keeps its own speed (AC_WPNav).
_MIN_PACE, _MAX_PACE = 0.1, 10
_MAX_DURATION_S = 1_000_000  # 11 days.


def _number(text: str, or_words: str = "") -> float:
    """A finite number; ``or_words`` are what the option may be instead, such as " or all"."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a number{or_words}, not {_short(text)}") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"must be a finite number, not {_short(text)}")
    return value


def _at_most(value: float, limit: float) -> float:
    if value > limit:
        raise argparse.ArgumentTypeError(f"must be {limit:.0f} or less, not {value:g}")
    return value


def _at_least(value: float, limit: float) -> float:
    if value < limit:
        raise argparse.ArgumentTypeError(f"must be {limit:g} or more, not {value:g}")
    return value


def positive(text: str, or_words: str = "") -> float:
    """A finite number greater than 0; see ``_number``."""
    value = _number(text, or_words)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"must be greater than 0, not {value:g}")
    return value


def not_negative(text: str) -> float:
    """A finite number of 0 or more."""
    value = _number(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"must be 0 or more, not {value:g}")
    return value


def count(text: str) -> int:
    """A whole number of 1 or more."""
    if not (text.isascii() and text.isdecimal() and len(text) <= _MAX_DIGITS) or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number of 1 or more, not {_short(text)}")
    return int(text)


def _short(text: str) -> str:
    """A quotation of a value of any length."""
    return repr(text if len(text) <= _MAX_QUOTED else text[:_MAX_QUOTED] + "...")


def points(text: str) -> int:
    """A number of waypoints that MAVLink can count, each with a speed."""
    return int(_at_most(count(text), _MAX_POINTS))


def baud(text: str) -> int:
    """The baud rate of a serial port."""
    return int(_at_most(count(text), _MAX_BAUD))


def speedup(text: str) -> float:
    """A multiple of real time."""
    return _at_least(_at_most(positive(text), _MAX_SPEEDUP), _MIN_SPEEDUP)


def height(text: str, or_words: str = "") -> float:
    """Metres above home that ArduPilot can store; see ``_number``."""
    return _at_most(positive(text, or_words), _MAX_HEIGHT_M)


def altitude(text: str) -> tuple[float | Recorded, float]:
    """Metres above home, or ``RECORDED``; and how many metres to fly above that (recorded+10)."""
    if text == RECORDED:
        return RECORDED, 0.0
    if text.startswith(f"{RECORDED}+"):
        return RECORDED, height(text.removeprefix(f"{RECORDED}+"))
    return height(text, ", recorded or recorded+M"), 0.0


def pace(text: str) -> float:
    """A multiple of the recorded speed."""
    return _at_least(_at_most(positive(text), _MAX_PACE), _MIN_PACE)


def speed(text: str) -> tuple[float | Recorded | None, float]:
    """Metres per second, ``RECORDED``, or None for the vehicle's own setting; and the pace (0.5x)."""
    if text == "vehicle":
        return None, 1.0
    if text == RECORDED:
        return RECORDED, 1.0
    if text.endswith("x"):
        return RECORDED, pace(text.removesuffix("x"))
    m_s = positive(text, ", vehicle, recorded or a factor such as 0.5x")
    return _at_least(_at_most(m_s, _MAX_SPEED_M_S), _MIN_SPEED_M_S), 1.0


def duration(text: str) -> float | None:
    """Seconds, or None for the whole mission."""
    return None if text == "all" else _at_most(positive(text, " or all"), _MAX_DURATION_S)


def vehicle_id(text: str) -> tuple[int, int | None]:
    """SYSID[:COMPID] as (system, component or None)."""
    system, _, component = text.partition(":")
    parts = [system, component] if ":" in text else [system]
    digits = all(part.isascii() and part.isdecimal() and len(part) <= _MAX_DIGITS for part in parts)
    if not digits or max(map(int, parts)) > 255:
        raise argparse.ArgumentTypeError(f"must be SYSID or SYSID:COMPID, each 0 to 255, not {_short(text)}")
    return int(system), int(component) if component else None

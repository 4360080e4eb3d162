"""What option values may look like: each function turns the text of one into its value."""

from __future__ import annotations

import argparse
import math

from flight_replay.planning.altitude import RECORDED, Recorded


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def positive(text: str) -> float:
    """A finite number above 0."""
    value = _number(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text} is not above 0")
    return value


def not_negative(text: str) -> float:
    """A finite number from 0 up."""
    value = _number(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text} is below 0")
    return value


def count(text: str) -> int:
    """A whole number from 1 up."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1 up")
    return int(text)


def altitude(text: str) -> float | Recorded:
    """Metres above home, or as recorded."""
    return RECORDED if text == RECORDED else positive(text)


def speed(text: str) -> float | Recorded | None:
    """Metres per second, as recorded, or None for the vehicle's own setting."""
    if text == "vehicle":
        return None
    return RECORDED if text == RECORDED else positive(text)


def duration(text: str) -> float | None:
    """Seconds, or None for all of it."""
    return None if text == "all" else positive(text)


def vehicle_id(text: str) -> tuple[int, int | None]:
    """SYSID[:COMPID] as (system, component or None)."""
    system, _, component = text.partition(":")
    parts = [system, component] if ":" in text else [system]
    if not all(part.isdecimal() and int(part) <= 255 for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r} is not SYSID or SYSID:COMPID, each 0 to 255")
    return int(system), int(component) if component else None

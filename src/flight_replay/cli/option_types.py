"""Parsers of option values: each function turns the text of a value into the value."""

from __future__ import annotations

import argparse
import math

from flight_replay.planning.altitude import RECORDED, Recorded


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a number, not {text!r}") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"must be a finite number, not {text!r}")
    return value


def positive(text: str) -> float:
    """A finite number greater than 0."""
    value = _number(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"must be greater than 0, not {text}")
    return value


def not_negative(text: str) -> float:
    """A finite number of 0 or more."""
    value = _number(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"must be 0 or more, not {text}")
    return value


def count(text: str) -> int:
    """A whole number of 1 or more."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number of 1 or more, not {text!r}")
    return int(text)


def altitude(text: str) -> float | Recorded:
    """Metres above home, or ``RECORDED``."""
    return RECORDED if text == RECORDED else positive(text)


def speed(text: str) -> float | Recorded | None:
    """Metres per second, ``RECORDED``, or None for the vehicle's own setting."""
    if text == "vehicle":
        return None
    return RECORDED if text == RECORDED else positive(text)


def duration(text: str) -> float | None:
    """Seconds, or None for the whole mission."""
    return None if text == "all" else positive(text)


def vehicle_id(text: str) -> tuple[int, int | None]:
    """SYSID[:COMPID] as (system, component or None)."""
    system, _, component = text.partition(":")
    parts = [system, component] if ":" in text else [system]
    if not all(part.isdecimal() and int(part) <= 255 for part in parts):
        raise argparse.ArgumentTypeError(f"must be SYSID or SYSID:COMPID, each 0 to 255, not {text!r}")
    return int(system), int(component) if component else None

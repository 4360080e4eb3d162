"""Dives: descents much faster than the vehicle may descend, out of a spline that it flies too fast."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.movement import Movement
from flight_replay.simulator.dynamics.limits import Limits

STEP_S = 0.1
_SPAN_S = 1.0
_FASTER = 2.0
"""The controller may be faster than a limit by less, and for less long, on its way back to its target."""


def too_fast_m_s(limits: Limits) -> float:
    """The rate of descent from which on it is a dive."""
    return _FASTER * limits.wp_speed_down_m_s


def falls_m_s(time_s: Floats, up_m: Floats) -> Floats:
    """Mean rates of descent (k,) over the second from each ``STEP_S`` of a flight on.

    Args:
        time_s: rising (n,).
        up_m: heights at those times (n,).
    """
    heights_m = np.interp(np.arange(time_s[0], time_s[-1], STEP_S), time_s, up_m)
    span = round(_SPAN_S / STEP_S)
    if len(heights_m) <= span:
        return np.zeros(0)
    return np.asarray((heights_m[:-span] - heights_m[span:]) / _SPAN_S)


def dive_note(flown: Movement, limits: Limits) -> str:
    """A sentence on the fastest dive of a predicted flight; empty where there is none.

    Args:
        flown: at least one position, its times counting from the first waypoint.
        limits: what the vehicle may do.
    """
    falls = falls_m_s(flown.time_s, flown.up_m)
    if not len(falls) or falls.max() <= too_fast_m_s(limits):
        return ""
    worst = int(falls.argmax())
    return (
        f"The vehicle is expected to fall out of a curve at {falls[worst]:.0f} m/s, "
        f"{flown.time_s[0] + STEP_S * worst:.0f} s after the first waypoint; its descents are limited to "
        f"{limits.wp_speed_down_m_s:.2g} m/s. Plan it otherwise, such as with a lower --speed, a constant "
        "--altitude or another --max-points."
    )

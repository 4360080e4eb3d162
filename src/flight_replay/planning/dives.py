"""Dives: descents much faster than the vehicle may descend, out of a spline that it flies too fast."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.movement import Movement
from flight_replay.simulator.dynamics.limits import Limits

_SPAN_S, _STEP_S = 1.0, 0.1
_FASTER = 2.0
"""The controller may be faster than a limit by less, and for less long, on its way back to its target."""


def dive_note(flown: Movement, limits: Limits) -> str:
    """A sentence on the fastest dive of a predicted flight; empty where there is none.

    Args:
        flown: at least one position, its times counting from the first waypoint.
        limits: what the vehicle may do.
    """
    times_s = np.arange(flown.time_s[0], flown.time_s[-1], _STEP_S)
    up_m = np.interp(times_s, flown.time_s, flown.up_m)
    span = round(_SPAN_S / _STEP_S)
    if len(up_m) <= span:
        return ""
    falls_m_s = (up_m[:-span] - up_m[span:]) / _SPAN_S
    worst = int(falls_m_s.argmax())
    if falls_m_s[worst] <= _FASTER * limits.wp_speed_down_m_s:
        return ""
    return (
        f"The vehicle is expected to fall out of a curve at {falls_m_s[worst]:.0f} m/s, "
        f"{times_s[worst]:.0f} s after the first waypoint; its descents are limited to "
        f"{limits.wp_speed_down_m_s:.2g} m/s. Plan it otherwise, such as with a lower --speed, a constant "
        "--altitude or another --max-points."
    )

"""Which targets are outside the fence: its heights and its circle around home (AC_Fence.cpp).

Targets outside are dropped (check_destination_within_fence). There are no polygons, and no breaches.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot

from flight_replay.simulator.dynamics.vector import Vector, minus

# FENCE_TYPE.
_ALT_MAX, _CIRCLE, _ALT_MIN = 1, 2, 8


def is_within_fence(parameters: Mapping[str, float], home_m: Vector, position_m: Vector) -> bool:
    """Whether a target may be flown to; any may without FENCE_ENABLE."""
    if not parameters["FENCE_ENABLE"]:
        return True
    kinds = int(parameters["FENCE_TYPE"])
    north_m, east_m, up_m = minus(position_m, home_m)
    too_high = kinds & _ALT_MAX and up_m > parameters["FENCE_ALT_MAX"]
    too_low = kinds & _ALT_MIN and up_m < parameters["FENCE_ALT_MIN"]
    too_far = kinds & _CIRCLE and hypot(north_m, east_m) > parameters["FENCE_RADIUS"]
    return not (too_high or too_low or too_far)

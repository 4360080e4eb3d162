"""Which targets are outside the fence: its heights and its circle around home (AC_Fence.cpp).

Targets outside are dropped (check_destination_within_fence). There are no polygons, and no breaches.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot

from flight_replay.mission.fence import FenceType
from flight_replay.simulator.dynamics.vector import Vector, minus


def is_within_fence(parameters: Mapping[str, float], home_m: Vector, position_m: Vector) -> bool:
    """Whether a target may be flown to; any may without FENCE_ENABLE."""
    if not parameters["FENCE_ENABLE"]:
        return True
    kinds = FenceType(int(parameters["FENCE_TYPE"]))
    north_m, east_m, up_m = minus(position_m, home_m)
    too_high = FenceType.ALT_MAX in kinds and up_m > parameters["FENCE_ALT_MAX"]
    too_low = FenceType.ALT_MIN in kinds and up_m < parameters["FENCE_ALT_MIN"]
    too_far = FenceType.CIRCLE in kinds and hypot(north_m, east_m) > parameters["FENCE_RADIUS"]
    return not (too_high or too_low or too_far)

"""How long a row of straight legs takes, calculated leg by leg instead of step by step.

The legs and how they overlap are those that are flown (``scurve``, ``leg_blending``). The vehicle is
left out: it follows its target at a delay that hardly depends on the path.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector, minus
from flight_replay.simulator.navigation.leg_blending import can_blend, earliest_blend_s
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.scurve import SCurve

_TOLERANCE_S: Final = 0.01
"""How exactly the start of a blend is found."""


def straight_duration_s(positions: Sequence[Vector], limits: Limits) -> float:
    """Seconds from rest at the first position to rest at the last, along straight legs without holds."""
    path_limits = PathLimits(
        limits.wp_speed_m_s,
        limits.wp_speed_up_m_s,
        limits.wp_speed_down_m_s,
        limits.wp_accel_m_s2,
        limits.wp_accel_z_m_s2,
        limits.path_jerk_m_s3,
        limits.path_snap_m_s4,
    )
    legs = [SCurve(minus(there, here), path_limits) for here, there in pairwise(positions) if here != there]
    if not legs:
        return 0.0
    total_s = since_s = 0.0
    for leg, following in pairwise(legs):
        blend_s = _blend_start_s(leg, following, limits, since_s)
        total_s += blend_s
        # Half-way through the blend the following leg becomes the current one.
        since_s = 0.5 * (leg.end_time - blend_s)
    return total_s + legs[-1].end_time


def _blend_start_s(leg: SCurve, following: SCurve, limits: Limits, since_s: float) -> float:
    """When the following leg begins, seconds from the start of the leg; not before ``since_s``."""
    early_s, late_s = max(since_s, earliest_blend_s(leg, following, limits)), leg.end_time
    while late_s - early_s > _TOLERANCE_S:
        middle_s = 0.5 * (early_s + late_s)
        leg.time, leg.position = middle_s, leg.at(middle_s)[0]
        if can_blend(leg, following, limits):
            late_s = middle_s
        else:
            early_s = middle_s
    return late_s

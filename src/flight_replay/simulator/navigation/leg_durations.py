"""How long a row of straight legs takes, found leg by leg instead of step by step.

The legs and the rule by which they overlap are those that are flown (``scurve``, ``straight_legs``);
what is left out is the vehicle, which is behind its target by a moment that hardly depends on the way.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector, minus
from flight_replay.simulator.navigation.leg_blending import may_turn
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.scurve import SCurve

_EXACT_S = 0.01
"""How exactly the moment is found at which a leg begins to turn into the next."""


def straight_duration_s(places: Sequence[Vector], limits: Limits) -> float:
    """Seconds from rest at the first place to rest at the last, along straight legs without holds."""
    path_limits = PathLimits(
        limits.wp_speed_m_s,
        limits.wp_speed_up_m_s,
        limits.wp_speed_down_m_s,
        limits.wp_accel_m_s2,
        limits.wp_accel_z_m_s2,
        limits.path_jerk_m_s3,
        limits.path_snap_m_s4,
    )
    legs = [SCurve(minus(there, here), path_limits) for here, there in pairwise(places) if here != there]
    if not legs:
        return 0.0
    total_s = since_s = 0.0
    for leg, following in pairwise(legs):
        turn_s = _turn_s(leg, following, limits, since_s)
        total_s += turn_s
        # Half-way through the turn the following leg becomes the one that is flown.
        since_s = 0.5 * (leg.end_time - turn_s)
    return total_s + legs[-1].end_time


def _turn_s(leg: SCurve, following: SCurve, limits: Limits, since_s: float) -> float:
    """When, from ``since_s`` on, the following leg begins: seconds from the leg's own beginning."""
    early_s, late_s = max(since_s, leg.turn_out_time - following.turn_in_time), leg.end_time
    while late_s - early_s > _EXACT_S:
        middle_s = 0.5 * (early_s + late_s)
        leg.time, leg.position = middle_s, leg.at(middle_s)[0]
        if may_turn(leg, following, limits):
            late_s = middle_s
        else:
            early_s = middle_s
    return late_s

"""What a route does with heights: the climb to its first waypoint, the floor, and what is not kept."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, copysign

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.mission.items import FIRST_SEQ, Mission
from flight_replay.planning.heights import HeightChange, RouteHeights
from flight_replay.planning.route import Route
from flight_replay.planning.stretches import worst_stretches
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.writing.counted import counted_of

_LEVEL_M = 0.05
"""A first waypoint so near to the take-off altitude is at it."""
_KEPT_M = 0.5
"""Heights that are nearer to the wanted ones than this are kept."""
_DOWNHILL_M = 3.0
"""Farther below home a recording led down a slope or a cliff; less may be a drift of the barometer."""
_SIDES = " too high", " too low"
_LONGEST_SIMULATED_CLIMB_M = 500.0
_STEP_S = 0.05
_BESIDE_DEG = 1e-4


def route_heights(
    route: Route, *, takeoff_m: float, floor_m: float | None, raise_m: float = 0.0
) -> RouteHeights:
    """What a route does with heights.

    Args:
        route: at least one waypoint, its altitudes above home.
        takeoff_m: take-off altitude.
        floor_m: the floor, where the altitude is as recorded.
        raise_m: how much higher than recorded the altitude is.
    """
    first_m = route.mission.waypoints[0][1].alt_m
    climbs = abs(first_m - takeoff_m) > _LEVEL_M
    climb_s = _climb_s(route.mission, takeoff_m, route.limits.limits)
    asked_m = route.recorded.alt_m + raise_m
    below_m = np.zeros(len(asked_m)) if floor_m is None else np.nan_to_num(floor_m - asked_m)
    raised = (below_m > 0) & (route.wanted.up_m == floor_m)
    off_m = route.planned_up_m - route.wanted.up_m
    off = np.abs(off_m) > _KEPT_M
    notes = [
        _climb_note(takeoff_m, first_m, climb_s, followed=route.reference is not None) if climbs else "",
        _floor_note(floor_m or 0.0, below_m[raised], len(raised), raise_m) if raised.any() else "",
        _limited_note(off, off_m, route.wanted.time_s) if off.any() else "",
    ]
    return RouteHeights(
        takeoff_m,
        first_m,
        climb_s,
        floor_m,
        _change(raised, below_m),
        _change(off, np.abs(off_m)),
        tuple(filter(None, notes)),
    )


def _climb_s(mission: Mission, takeoff_m: float, limits: Limits) -> float:
    """How long AUTO takes from the take-off to the first waypoint."""
    first = mission.waypoints[0][1]
    climb_m = first.alt_m - takeoff_m
    if abs(climb_m) > _LONGEST_SIMULATED_CLIMB_M:
        return abs(climb_m) / (limits.wp_speed_up_m_s if climb_m > 0 else limits.wp_speed_down_m_s)
    # The model of the whole vehicle takes as long to import as all else in a dry run.
    from flight_replay.simulator.flight.trajectory import simulate

    beside = replace(first, lat_deg=first.lat_deg - copysign(_BESIDE_DEG, first.lat_deg))
    flight = simulate(
        Mission((first, beside), mission.home),
        limits,
        start_m=(0.0, 0.0, takeoff_m),
        step_s=_STEP_S,
    )
    return flight.reached_s[FIRST_SEQ]


def _change(changed: Flags, by_m: Floats) -> HeightChange:
    return HeightChange(int(changed.sum()), float(by_m[changed].max(initial=0.0)))


def _climb_note(takeoff_m: float, first_m: float, climb_s: float, *, followed: bool) -> str:
    what = "climbs" if first_m > takeoff_m else "descends"
    where = "where the recording begins" if followed else "the first waypoint"
    return (
        f"After take-off to {takeoff_m:g} m the vehicle {what} {abs(first_m - takeoff_m):.1f} m to {where}, "
        f"at {first_m:.1f} m: {climb_s:.0f} s{'' if followed else ' of AUTO'}."
    )


def _floor_note(floor_m: float, below_m: Floats, of_fixes: int, raise_m: float) -> str:
    raised = f", {raise_m:g} m higher than recorded" if raise_m else ""
    told = (
        f"Below the floor of {floor_m:g} m, by up to {below_m.max():.1f} m: "
        f"{counted_of(len(below_m), of_fixes, 'flown fix')}{raised}; flown at the floor (--floor)."
    )
    if below_m.max() <= floor_m + _DOWNHILL_M and len(below_m) < of_fixes:
        return told
    return f"{told} To keep differences in height, add --altitude recorded+{ceil(raise_m + below_m.max())}."


def _limited_note(off: Flags, off_m: Floats, time_s: Floats) -> str:
    """A sentence on the stretches where heights are farthest off."""
    return (
        "The vehicle cannot climb and descend as fast as recorded everywhere: it begins sooner and ends "
        f"later, up to {worst_stretches(off, off_m, time_s, 1, _SIDES)}."
    )

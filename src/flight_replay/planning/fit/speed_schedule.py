"""When each place of a draft ought to be reached, and how long to wait where the recording hovered.

A vehicle that cannot keep up in one stretch is late in all that follow, unless it was early before
or hurries after. With the time that each leg takes at least, the lateness that costs the smallest
distance in time is an isotonic regression: lateness may fall from one place to the next only as
fast as the vehicle can hurry (Barlow et al., 1972: pool adjacent violators).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import segment_lengths_m
from flight_replay.planning.fit.climb_speeds import steep_legs
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.offsets import CURVE_TOLERANCE_M, Offsets
from flight_replay.planning.fit.reference import LEAST_HOLD_S, Hover, LocalTrack

SLOWEST_M_S = 0.35
"""ArduCopter ignores less than 0.2 m/s."""
SLOWEST_BETWEEN_WAITS_M_S = 0.7
"""A vehicle's estimate of its velocity is centimetres a second off: from rest to rest at 0.35 m/s a real one
came 0.2 s late, with all that followed. It waits instead."""
SLOWEST_CLIMB_M_S = 0.25
"""Of steep legs; it is their ground speed, too."""
FASTEST_M_S = 30.0
_LAG_S = 0.5
"""The vehicle passes a place so long after its target has reached it."""
_OFF_S = 0.6
"""As a hover ends the recorded vehicle leaves its circle, ``reference.HOVER_RADIUS_M``, and has been on its
way for about so long: 0.3 m from rest take (6 * 0.3 / 5)^(1/3) = 0.7 s at the 5 m/s³ of PSC_JERK_XY."""
_SPEED_HEADROOM = 1.4
_SPEED_HEADROOM_M_S = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Schedule:
    """When the target ought to leave each place (n,), s from the first; ``draft`` has the waits."""

    draft: Draft
    leave_s: Floats


def schedule(
    draft: Draft, hovers: dict[int, Hover], recording: LocalTrack, planned: Offsets, least_s: Floats
) -> Schedule:
    """When to leave each place so that the vehicle is as little late or early as it can be.

    Args:
        draft: whose places are to be passed.
        hovers: the recorded hovers by the place (from 1) at which they are waited for.
        recording: at least one fix.
        planned: where the planned path has the fixes.
        least_s: what each leg takes at least, waiting not counted (n,).
    """
    wanted_s = recorded_passing_s(planned, len(draft), hovers, recording)
    floor_s = least_s + np.minimum(draft.hold_s, LEAST_HOLD_S)
    weight = np.maximum(leg_lengths_m(draft), 0.1)
    late_s = best_lateness_s(np.diff(wanted_s, prepend=0.0), floor_s, weight)
    leave_s = np.maximum.accumulate(wanted_s + late_s)
    hold_s = draft.hold_s.copy()
    for place, hover in hovers.items():
        come_s = max(float(recording.time_s[hover.first]), leave_s[place - 1] + least_s[place])
        hold_s[place] = max(LEAST_HOLD_S, np.floor(leave_s[place] - come_s))
    return Schedule(replace(draft, hold_s=hold_s), leave_s)


def recorded_passing_s(
    planned: Offsets, places: int, hovers: dict[int, Hover], recording: LocalTrack
) -> Floats:
    """When the target would pass each of the places (n,) if the vehicle flew as recorded.

    Args:
        planned: where the planned path has the fixes.
        places: how many the draft has.
        hovers: the recorded hovers by the place at which they are waited for.
        recording: at least one fix.
    """
    passing_s = planned.passing_s(places, recording.time_s)
    for place, hover in hovers.items():
        passing_s[place] = recording.time_s[hover.last] - _OFF_S
    passing_s = np.maximum.accumulate(passing_s) - _LAG_S
    passing_s[0] = 0.0
    return np.maximum(passing_s, 0.0)


def leg_lengths_m(draft: Draft) -> Floats:
    """Planned lengths (n,) of the legs to a draft's places."""
    path = draft.path(CURVE_TOLERANCE_M)
    steps = np.append(0.0, segment_lengths_m(np.column_stack([path.north_east_m, path.up_m])))
    return np.bincount(path.seq, steps, minlength=len(draft)).astype(float)


def speed_caps_m_s(planned: Offsets, legs: int, recording: LocalTrack) -> Floats:
    """Highest speed to ask for on each leg (n,): 1.4 times the recorded one and 1 m/s more, within bounds.

    Args:
        planned: where the planned path has the fixes.
        legs: how many there are.
        recording: at least one fix.
    """
    speed = recording.fastest_m_s
    caps = np.full(legs, np.nan)
    for here in np.unique(planned.leg):
        caps[here] = speed[planned.leg == here].max()
    caps = np.where(np.isnan(caps), np.nanmax(caps), caps)
    return np.clip(_SPEED_HEADROOM * caps + _SPEED_HEADROOM_M_S, SLOWEST_BETWEEN_WAITS_M_S, FASTEST_M_S)


def slowest_m_s(draft: Draft) -> Floats:
    """Lowest speed to ask for on each leg (n,)."""
    waits = draft.hold_s > 0
    between = waits & np.append(False, waits[:-1])
    slowest = np.where(between, SLOWEST_BETWEEN_WAITS_M_S, SLOWEST_M_S)
    return np.where(steep_legs(draft.places_m), SLOWEST_CLIMB_M_S, slowest)


def with_speeds(draft: Draft, speeds_m_s: Floats) -> Draft:
    """The draft with the speeds (n,) of its legs, but for the first; what goes on as before is not said."""
    kept = np.full(len(draft), np.nan)
    in_force = np.nan
    for place in range(1, len(draft)):
        speed = round(float(speeds_m_s[place]), 2)
        if speed != in_force:
            kept[place] = in_force = speed
    return replace(draft, speed_m_s=kept)


def best_lateness_s(wanted_s: Floats, least_s: Floats, weight: Floats) -> Floats:
    """Lateness (n,) at each place with the smallest weighted sum of sizes, zero at the first.

    Args:
        wanted_s: recorded duration of each leg (n,); that to the first place is not used.
        least_s: shortest duration of each leg (n,).
        weight: what a second of lateness costs around each place (n,).
    """
    forced = np.cumsum(np.append(0.0, (least_s - wanted_s)[1:]))
    # Lateness less what is forced never falls; it starts at 0, whatever that costs.
    return np.asarray(np.maximum(_rising_median(-forced, weight), 0.0) + forced)


def _rising_median(values: Floats, weight: Floats) -> Floats:
    """Never falling numbers nearest to ``values`` by weighted absolute distance."""
    pools: list[tuple[int, int, float]] = []
    for i, value in enumerate(values.tolist()):
        pool = (i, i + 1, value)
        while pools and pools[-1][2] > pool[2]:
            begin = pools.pop()[0]
            pool = (begin, pool[1], _median(values[begin : pool[1]], weight[begin : pool[1]]))
        pools.append(pool)
    return np.concatenate([np.full(end - begin, value) for begin, end, value in pools])


def _median(values: Floats, weight: Floats) -> float:
    order = np.argsort(values, kind="stable")
    total = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(total, 0.5 * total[-1])])

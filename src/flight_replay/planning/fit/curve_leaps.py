"""Drafts without curves that ArduPilot may leap through.

A curve from a stop has no tangent where it begins, so its first step goes by the speed that the leg before
has left, and its second by the tangent that the first came to (SplineCurve::calc_dt_speed_max). With steps
of dt, an acceleration a along the curve and a speed v that is left the second goes a² dt³ / 4 v far: 0.6 m
with 0.01 µm/s. Straight legs leave none at all (SCurve::add_segments), unless they begin in motion: they are
planned anew then, and what rounding makes of no speed stays (SCurve::set_origin_speed_max). Three quarters
of those at 0.35 m/s leave just that, and the vehicle is up to a second early for all that follows; faster
ones leave more.

Such stops are rare, so they are mended after the search: reached on a curve, left straight, or reached from
rest.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.rounds import changed_flown
from flight_replay.planning.fit.speed_schedule import LEAST_HOLD_S

_SLOW_M_S = 0.5


def without_leaps(problem: FitProblem, best: Evaluation) -> Evaluation:
    """The best draft like ``best`` without such curves, as far as the stops before them can be mended."""
    found = best
    for _ in range(len(best.draft)):
        leaps = places_before_leaps(found.draft)
        if not leaps:
            break
        up = changed_flown(problem, _changes(found, leaps[0]))
        mended = [each for each in up if len(places_before_leaps(each.draft)) < len(leaps)]
        if not mended:
            break
        found = min(mended, key=lambda each: each.objective_m)
    return found


def places_before_leaps(draft: Draft) -> list[int]:
    """The stops that slow straight legs lead to, begun in motion, and that are left on a curve."""
    waits, last = draft.hold_s > 0, len(draft) - 1
    speeds_m_s = with_every_speed(draft).speed_m_s
    return [
        place
        for place in range(1, last)
        if waits[place] and not waits[place - 1] and speeds_m_s[place] < _SLOW_M_S
        if draft.spline[place + 1] and not draft.spline[place]
    ]


def _changes(evaluation: Evaluation, place: int) -> Iterator[tuple[Draft, Floats]]:
    """What may be made of a stop, and when the places are left then."""
    draft = with_every_speed(evaluation.draft)
    reached_curved, left_straight, from_rest = draft.spline.copy(), draft.spline.copy(), draft.hold_s.copy()
    reached_curved[place], left_straight[place + 1], from_rest[place - 1] = True, False, LEAST_HOLD_S
    changed = [replace(draft, spline=spline) for spline in (reached_curved, left_straight)]
    for each in (*changed, replace(draft, hold_s=from_rest)):
        yield each, evaluation.passed_s

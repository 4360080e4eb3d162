"""Drafts without curves that ArduPilot may leap through.

A curve from a stop has no tangent where it begins, so its first step goes by the speed that the leg before
has left, and its second by the tangent that the first came to (SplineCurve::calc_dt_speed_max). With steps
of dt, an acceleration a along the curve and a speed v that is left the second goes a² dt³ / 4 v far: 0.6 m
with 0.01 µm/s. Straight legs leave none at all (SCurve::add_segments), unless they begin in motion: they are
planned anew then, and what rounding makes of no speed stays (SCurve::set_origin_speed_max). Three quarters
of those at 0.35 m/s leave just that, and the vehicle is up to a second early for all that follows; faster
ones leave more.

Such stops are rare, so they are mended after the search: reached on a curve, left straight, reached from
rest, or sooner, to wait longer.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Flags
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import LEAST_HOLD_S
from flight_replay.planning.fit.rounds import changed_flown

_SLOW_M_S = 0.5


def without_leaps(problem: FitProblem, best: Evaluation) -> Evaluation:
    """The best draft like ``best`` without such curves, as far as the stops before them can be mended."""
    found = best
    for _ in range(len(best.draft)):
        leaps = places_before_leaps(found.draft)
        if not leaps:
            break
        up = _flown(problem, found, leaps[0])
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


def _flown(problem: FitProblem, evaluation: Evaluation, place: int) -> list[Evaluation]:
    """What becomes of a stop, changed in one way or another, in which the vehicle stays up."""
    changed, leave_s = _changes(evaluation, place), evaluation.passed_s
    found = changed_flown(problem, ((draft, leave_s) for draft in changed))
    if problem.timed:
        draft = with_every_speed(evaluation.draft)
        sooner = replace(draft, speed_m_s=np.where(_at(place, draft), _SLOW_M_S, draft.speed_m_s))
        for each in (*changed, sooner):
            with suppress(MissionError):
                found.append(_waiting_until(problem, each, place, float(leave_s[place])))
    return [each for each in found if each.flight.stays_up]


def _waiting_until(problem: FitProblem, draft: Draft, place: int, leave_s: float) -> Evaluation:
    """A draft flown at the speeds it has, with a wait that ends as near as can be to when it ought to."""
    found = problem.exact.evaluate(draft)
    late_s = round(float(found.passed_s[place]) - leave_s)
    wait_s = max(draft.hold_s[place] - late_s, LEAST_HOLD_S)
    waiting = replace(draft, hold_s=np.where(_at(place, draft), wait_s, draft.hold_s))
    return problem.exact.evaluate(waiting) if late_s else found


def _changes(evaluation: Evaluation, place: int) -> list[Draft]:
    """What may be made of a stop."""
    draft = with_every_speed(evaluation.draft)
    here, before, behind = (_at(each, draft) for each in (place, place - 1, place + 1))
    return [
        replace(draft, spline=draft.spline | here),
        replace(draft, spline=draft.spline & ~behind),
        replace(draft, hold_s=np.where(before, LEAST_HOLD_S, draft.hold_s)),
    ]


def _at(place: int, draft: Draft) -> Flags:
    """Where a place is (n,)."""
    return np.asarray(np.arange(len(draft)) == place)

"""Drafts without the legs on which ArduPilot reports an internal error.

Up to 4.7 SCurve::calculate_path looks for a full ramp where only a smaller one fits, and finds none: on
straight legs of about half a metre to a metre that are left or reached at half of their speed. It reports an
internal error then, and a vehicle does not arm again before a reboot. Such legs are rare, so they are mended
after the search: made shorter or longer, flown to on a curve, left out, or stopped at. AUTO itself makes one
behind a curve that the mission ends with: to the point at which the vehicle comes to rest.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import LEAST_HOLD_S
from flight_replay.planning.fit.rounds import changed_flown

_SHORT_M_PER_M_S3 = 2.0
"""Only legs that are shorter have such errors, by the jerk that the vehicle flies them with (WPNAV_JERK)."""
_STEP_S = 0.02
"""In longer steps of the model some of them do not show."""
_LENGTHS = (0.5, 0.7, 0.85, 1.2, 1.5, 2.0)
_MOST_ROUNDS = 10


def without_errors(problem: FitProblem, best: Evaluation) -> Evaluation:
    """The best draft near ``best`` without such an error; ``best`` itself if none is found."""
    fine = replace(problem, step_s=min(problem.exact.step_s, _STEP_S))
    found = best if fine.step_s == problem.exact.step_s else fine.evaluate(best.draft)
    if not found.flight.has_error:
        return best
    for _ in range(_MOST_ROUNDS):
        short_m = _SHORT_M_PER_M_S3 * max(problem.limits.path_jerk_m_s3, 1.0)
        up = changed_flown(fine, _changes(found, short_m))
        mended = [each for each in up if not each.flight.has_error]
        if mended:
            return min(mended, key=lambda each: each.objective_m)
        if not up:
            break
        # Of several such legs one after the other is mended.
        found = min(up, key=lambda each: each.objective_m)
    return best


def _short_legs(draft: Draft, short_m: float) -> list[int]:
    """The places that straight legs lead to, so short, before or after a curve."""
    lengths_m = np.linalg.norm(np.diff(draft.places_m, axis=0, prepend=draft.places_m[:1]), axis=1)
    curves = np.append(draft.spline[1:], False) | np.append(False, draft.spline[:-1])
    short = ~draft.spline & curves & (lengths_m < short_m)
    return [int(place) for place in np.flatnonzero(short) if place > 0]


def _changes(evaluation: Evaluation, short_m: float) -> Iterator[tuple[Draft, Floats]]:
    """What may be made of each such leg, and when the places are left then."""
    draft, leave_s = with_every_speed(evaluation.draft), evaluation.passed_s
    if draft.spline[-1]:
        at_end = np.arange(len(draft)) == len(draft) - 1
        yield replace(draft, spline=draft.spline & ~at_end), leave_s
        yield replace(draft, hold_s=np.where(at_end, LEAST_HOLD_S, draft.hold_s)), leave_s
    for place in _short_legs(draft, short_m):
        curved, waits = draft.spline.copy(), draft.hold_s.copy()
        curved[place], waits[place] = True, LEAST_HOLD_S
        for share in _LENGTHS:
            moved = draft.places_m.copy()
            moved[place] = moved[place - 1] + share * (moved[place] - moved[place - 1])
            yield replace(draft, places_m=moved), leave_s
        yield replace(draft, spline=curved), leave_s
        if draft.hold_s[place] > 0:
            continue
        yield replace(draft, hold_s=waits), leave_s
        if place < len(draft) - 1:
            yield draft.select(np.arange(len(draft)) != place), np.delete(leave_s, place)

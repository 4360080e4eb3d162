"""Drafts without dives: descents much faster than the vehicle may descend.

A spline that leads from level flight down steeply bends sooner than its target slows down: 4.6 fell from 20 m
to 10 m at up to 4.4 m/s where a recording ends straight down, and from 60 m to 6 m at 8 m/s behind one of
15 m/s, with WPNAV_SPEED_DN 1.5 m/s. The search does not mind, as a vehicle that falls comes down sooner. So
the legs around a dive are flown straight, or left from a stop.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.dives import STEP_S, falls_m_s, too_fast_m_s
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import LEAST_HOLD_S
from flight_replay.planning.fit.rounds import changed_flown
from flight_replay.simulator.dynamics.limits import Limits

_MOST_ROUNDS = 10
_LESS = 0.7
"""A mend leaves less than this of what the vehicle falls; of several dives one after the other is mended."""
_SLOWER = (0.7, 0.4)


def without_dives(problem: FitProblem, best: Evaluation) -> Evaluation:
    """The best draft near ``best`` in which the vehicle does not dive, or dives less."""
    found, dive_m = best, _dived_m(best, problem.limits)
    for _ in range(_MOST_ROUNDS):
        if not dive_m.any():
            break
        flown = changed_flown(problem, _changes(problem, found, _place_of(found, dive_m)))
        dived = [(float(_dived_m(each, problem.limits).sum()), each) for each in flown]
        mended = [(fall_m, each) for fall_m, each in dived if fall_m < _LESS * dive_m.sum()]
        if not mended:
            break
        # Without any dive the best one, or else that with the least.
        found = min(mended, key=lambda pair: (pair[0], pair[1].objective_m))[1]
        dive_m = _dived_m(found, problem.limits)
    return found


def _dived_m(evaluation: Evaluation, limits: Limits) -> Floats:
    """How far the vehicle falls too fast from each ``STEP_S`` of its flight to the next (k,)."""
    flight = evaluation.flight
    falls = falls_m_s(flight.time_s, flight.place_m[:, 2])
    return np.where(falls > too_fast_m_s(limits), falls * STEP_S, 0.0)


def _place_of(evaluation: Evaluation, dive_m: Floats) -> int:
    """The place that is flown to as the worst dive begins."""
    begin_s = STEP_S * int(dive_m.argmax())
    place = int(np.searchsorted(evaluation.passed_s, begin_s, side="right"))
    return min(place, len(evaluation.draft) - 1)


def _changes(problem: FitProblem, evaluation: Evaluation, place: int) -> Iterator[tuple[Draft, Floats]]:
    """What may be made of the legs around a dive, and when the places are left then."""
    draft, leave_s = evaluation.draft, evaluation.passed_s
    at = np.arange(len(draft))
    for first in range(max(place - 1, 1), place + 1):
        for last in range(place, min(place + 2, len(draft))):
            straight = draft.spline & ~((at >= first) & (at <= last))
            yield replace(draft, spline=straight), leave_s
            stop = np.where((at == first - 1) & (draft.hold_s == 0), LEAST_HOLD_S, draft.hold_s)
            yield replace(draft, spline=straight, hold_s=stop), leave_s
            if not problem.timed:
                continue
            speeds_m_s = with_every_speed(draft).speed_m_s
            for share in _SLOWER:
                slower = np.where((at >= first) & (at <= last), share, 1.0) * speeds_m_s
                yield replace(draft, spline=straight, speed_m_s=slower), leave_s

"""Legs straight or curved, places flown through or stopped at: changed one by one where that gains.

Each change is flown in the model over the legs around it, and kept if they cost less of the objective.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.legs.lateness import Lateness
from flight_replay.planning.fit.legs.leg_changes import corner_changes, kind_changes, speed_changes
from flight_replay.planning.fit.legs.local_cost import LocalCost
from flight_replay.planning.fit.legs.local_flights import LocalFlights
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import Budget, FitProblem
from flight_replay.planning.fit.reference import Hover
from flight_replay.planning.fit.speed_schedule import LEAST_HOLD_S, recorded_passing_s, speed_caps_m_s

_LEGS_BEFORE, _LEGS_AFTER = 2, 2
"""A leg's kind shapes the leg before, whose speed the leg before that prepares for, and some after."""
_LEAST_GAIN_M = 0.001
_PATIENCE, _PATIENCE_S = 2.0, 60.0
"""Some legs may take so many times as long as the whole flight did before, and a minute."""
_PUNCTUAL_S, _MOST_FACTORS = 0.1, (0.5, 2.0)
_MADE_GOOD_S = 0.5
"""On few legs not much more than this is made good."""
USUAL_SHARE, LATER_SHARE = 0.25, 0.75
"""Legs that cost less than this of the mean are left as they are, the first time and later."""


def with_better_legs(
    problem: FitProblem,
    start: Evaluation,
    hovers: dict[int, Hover],
    budget: Budget,
    share: float = USUAL_SHARE,
) -> Draft:
    """The draft with its legs' kinds, its stops and speeds changed where that gains, from first to last.

    Args:
        problem: what to fit.
        start: the draft as it is flown.
        hovers: the recorded hovers by the place at which they are waited for.
        budget: is told how much was flown.
        share: legs that cost less than this share of the mean are left as they are.
    """
    if len(start.draft) < 2:
        return start.draft
    flights = LocalFlights(problem, start.draft, _PATIENCE * float(start.flight.time_s[-1]) + _PATIENCE_S)
    sweep = _Sweep(problem, start, hovers, flights, share)
    for place in range(1, len(start.draft)):
        sweep.visit(place)
    budget.spend(flights.steps * problem.step_s / max(float(start.flight.time_s[-1]), problem.step_s))
    return flights.draft


class _Sweep:
    """One way through the places of a draft, each changed where that gains."""

    def __init__(
        self,
        problem: FitProblem,
        start: Evaluation,
        hovers: dict[int, Hover],
        flights: LocalFlights,
        share: float,
    ) -> None:
        self._flights, self._hovers, self._timed = flights, hovers, problem.timed
        self._start, self._straight_starts = start, problem.straight_starts
        self._usual_m = share * start.objective_m / len(start.draft)
        self._cost = LocalCost.of(start, problem.recording, timed=problem.timed)
        self._lateness = _lateness(problem, start, hovers) if problem.timed else None

    def visit(self, place: int) -> None:
        """Change how a place is flown to, if that gains."""
        last = min(place + _LEGS_AFTER, len(self._start.draft) - 1)
        first = max(1, place - _LEGS_BEFORE)
        draft = self._flights.draft
        changes: list[tuple[int, Iterator[Sequence[Draft]]]] = [
            (first, kind_changes(draft, place, self._hovers, straight_starts=self._straight_starts)),
            (first, corner_changes(draft, place, self._hovers, self._cost.fixes_m(place, place + 1))),
        ]
        if self._timed:
            changes.insert(0, (place, speed_changes(draft, place, self._factor_to_be_on_time(place))))
        best: tuple[float, Draft, int] = _LEAST_GAIN_M, draft, first
        for begin, several in changes:
            before_m = self._cost_m(draft, begin, last)
            if before_m < self._usual_m * (last - begin + 1):
                continue
            for row in several:
                best = self._best_of(row, begin, last, before_m, best)
        if best[1] is not draft:
            self._flights.change(*best[1:])

    def _factor_to_be_on_time(self, place: int) -> float:
        """How many times as fast a leg would have to be to make good what the changes before it have cost."""
        began_s, left_s = self._flights.left_s(place - 1), self._flights.left_s(place)
        later_s, lasts_s = left_s - float(self._start.passed_s[place]), left_s - began_s
        if abs(later_s) < _PUNCTUAL_S:
            return 1.0
        return float(np.clip(lasts_s / max(lasts_s - later_s, 0.1 * lasts_s), *_MOST_FACTORS))

    def _best_of(
        self, row: Sequence[Draft], first: int, last: int, before_m: float, best: tuple[float, Draft, int]
    ) -> tuple[float, Draft, int]:
        """What gains most of the best so far and of the drafts in a row, tried as long as they gain more."""
        gained_m = 0.0
        for trial in row:
            gain_m = before_m - self._cost_m(trial, first, last, before_m)
            if gain_m <= gained_m:
                break
            gained_m = gain_m
            if gain_m > best[0]:
                best = gain_m, trial, first
        return best

    def _cost_m(self, draft: Draft, first: int, last: int, most_m: float | None = None) -> float:
        """What some legs of a draft cost; infinitely much if they do not end, or so late that it is more."""
        try:
            flown = self._flights.fly(draft, first, last, self._latest_s(last, most_m))
        except MissionError:
            return np.inf
        cost_m = self._cost.of_legs(draft, flown, first, last)
        if self._lateness is None:
            return cost_m
        return cost_m + self._lateness.cost_m(last, flown.left_s - float(self._start.passed_s[last]))

    def _latest_s(self, last: int, most_m: float | None) -> Floats | None:
        """When each place has to be left (n,) if being late is to cost less than so much."""
        if self._lateness is None or most_m is None:
            return None
        return self._start.passed_s + self._lateness.most_later_s(last, most_m) + _MADE_GOOD_S


def _lateness(problem: FitProblem, start: Evaluation, hovers: dict[int, Hover]) -> Lateness:
    caps_m_s = speed_caps_m_s(start.draft, problem.recording)
    wanted_s = recorded_passing_s(start.draft, hovers, problem.recording)
    least_s = problem.least_leg_s(start.draft, caps_m_s) + np.minimum(start.draft.hold_s, LEAST_HOLD_S)
    return Lateness.of(start, problem.recording, wanted_s, least_s)

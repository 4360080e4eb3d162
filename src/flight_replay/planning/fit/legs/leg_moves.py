"""Legs straight or curved, places flown through or stopped at: changed one by one where that gains.

Each change is flown in the model over the legs around it, and kept if they cost less of the objective.
"""

from __future__ import annotations

from itertools import chain

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.legs.leg_changes import corner_changes, kind_changes
from flight_replay.planning.fit.legs.local_cost import LocalCost
from flight_replay.planning.fit.legs.local_flights import LocalFlights
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import Budget, FitProblem
from flight_replay.planning.fit.reference import Hover

_LEGS_BEFORE, _LEGS_AFTER = 2, 2
"""A leg's kind shapes the leg before, whose speed the leg before that prepares for, and some after."""
_LEAST_GAIN_M = 0.001
_PATIENCE, _PATIENCE_S = 2.0, 60.0
"""Some legs may take so many times as long as the whole flight did before, and a minute."""
_USUAL_SHARE = 0.25
"""Legs that cost less than this of the mean are left as they are."""


def with_better_legs(
    problem: FitProblem, start: Evaluation, hovers: dict[int, Hover], budget: Budget
) -> Draft:
    """The draft with its legs' kinds and its stops changed where that gains, from first to last.

    Args:
        problem: what to fit.
        start: the draft as it is flown.
        hovers: the recorded hovers by the place at which they are waited for.
        budget: is told how much was flown.
    """
    if len(start.draft) < 2:
        return start.draft
    flights = LocalFlights(problem, start.draft, _PATIENCE * float(start.flight.time_s[-1]) + _PATIENCE_S)
    sweep = _Sweep(problem, start, hovers, flights)
    for place in range(1, len(start.draft)):
        sweep.visit(place)
    budget.spend(problem.flights_of(flights.steps, start.flight))
    return flights.draft


class _Sweep:
    """One way through the places of a draft, each changed where that gains."""

    def __init__(
        self,
        problem: FitProblem,
        start: Evaluation,
        hovers: dict[int, Hover],
        flights: LocalFlights,
    ) -> None:
        self._flights, self._hovers = flights, hovers
        self._start, self._straight_starts = start, problem.straight_starts
        self._usual_m = _USUAL_SHARE * start.objective_m / len(start.draft)
        self._cost = LocalCost.of(start, problem.recording)

    def visit(self, place: int) -> None:
        """Change how a place is flown to, if that gains."""
        last = min(place + _LEGS_AFTER, len(self._start.draft) - 1)
        first = max(1, place - _LEGS_BEFORE)
        draft = self._flights.draft
        before_m = self._cost_m(draft, first, last)
        if before_m < self._usual_m * (last - first + 1):
            return
        best: tuple[float, Draft] = _LEAST_GAIN_M, draft
        for changed in chain(
            kind_changes(draft, place, self._hovers, straight_starts=self._straight_starts),
            corner_changes(draft, place, self._hovers, self._cost.fixes_m(place, place + 1)),
        ):
            gain_m = before_m - self._cost_m(changed, first, last)
            best = max(best, (gain_m, changed), key=lambda each: each[0])
        if best[1] is not draft:
            self._flights.change(best[1], first)

    def _cost_m(self, draft: Draft, first: int, last: int) -> float:
        """What some legs of a draft cost; infinitely much if they do not end."""
        try:
            flown = self._flights.fly(draft, first, last)
        except MissionError:
            return np.inf
        return self._cost.of_legs(draft, flown, first, last)

"""Legs straight or curved, places flown through or stopped at: changed one by one where that gains.

Each change is flown in the model over the legs around it, and kept if they cost less of the objective.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flight_replay.errors import MissionError
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.legs.lateness import Lateness
from flight_replay.planning.fit.legs.local_cost import LocalCost
from flight_replay.planning.fit.legs.local_flights import LocalFlights
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import Budget, FitProblem
from flight_replay.planning.fit.reference import Hover
from flight_replay.planning.fit.speed_schedule import (
    FASTEST_M_S,
    LEAST_HOLD_S,
    SLOWEST_M_S,
    recorded_passing_s,
    speed_caps_m_s,
)

STOP_S = 1.0
_LEGS_BEFORE, _LEGS_AFTER = 2, 2
"""A leg's kind shapes the leg before, whose speed the leg before that prepares for, and some after."""
_LEAST_GAIN_M = 0.001
_PATIENCE, _PATIENCE_S = 2.0, 60.0
"""Some legs may take so many times as long as the whole flight did before, and a minute."""
_SPEED_FACTORS = (0.7, 0.87, 1.15, 1.4)
_USUAL_SHARE = 0.25
"""Legs that cost less than this of the mean are left as they are, but for their speeds."""


def with_better_legs(
    problem: FitProblem, start: Evaluation, hovers: dict[int, Hover], budget: Budget
) -> Draft:
    """The draft with the kinds of its legs and its stops changed where that gains, from first to last."""
    if len(start.draft) < 2:
        return start.draft
    flights = LocalFlights(problem, start.draft, _PATIENCE * float(start.flight.time_s[-1]) + _PATIENCE_S)
    sweep = _Sweep(problem, start, hovers, flights)
    for place in range(1, len(start.draft)):
        sweep.visit(place)
    budget.spend(flights.steps * problem.step_s / max(float(start.flight.time_s[-1]), problem.step_s))
    return flights.draft


class _Sweep:
    """One way through the places of a draft, each changed where that gains."""

    def __init__(
        self, problem: FitProblem, start: Evaluation, hovers: dict[int, Hover], flights: LocalFlights
    ) -> None:
        self._flights, self._hovers, self._timed = flights, hovers, problem.timed
        self._start = start
        self._usual_m = _USUAL_SHARE * start.objective_m / len(start.draft)
        self._cost = LocalCost.of(start, problem.recording, timed=problem.timed)
        self._lateness = _lateness(problem, start, hovers) if problem.timed else None

    def visit(self, place: int) -> None:
        """Change how a place is flown to, if that gains."""
        last = min(place + _LEGS_AFTER, len(self._start.draft) - 1)
        best: tuple[float, Draft, int] | None = None
        for first, changes in (
            (place, _speed_changes if self._timed else _no_changes),
            (max(1, place - _LEGS_BEFORE), _kind_changes),
        ):
            before_m = self._cost_m(self._flights.draft, first, last)
            if first < place and before_m < self._usual_m * (last - first + 1):
                break
            for trial in changes(self._flights.draft, place, self._hovers):
                gain_m = before_m - self._cost_m(trial, first, last)
                if gain_m > (_LEAST_GAIN_M if best is None else best[0]):
                    best = gain_m, trial, first
        if best is not None:
            self._flights.change(*best[1:])

    def _cost_m(self, draft: Draft, first: int, last: int) -> float:
        """What some legs of a draft cost; infinitely much if they do not end."""
        try:
            flown = self._flights.fly(draft, first, last)
        except MissionError:
            return np.inf
        cost_m = self._cost.of_legs(draft, flown, first, last)
        if self._lateness is None:
            return cost_m
        return cost_m + self._lateness.cost_m(last, float(flown.time_s[-1] - self._start.passed_s[last]))


def _lateness(problem: FitProblem, start: Evaluation, hovers: dict[int, Hover]) -> Lateness:
    caps_m_s = speed_caps_m_s(start.draft, problem.recording)
    wanted_s = recorded_passing_s(start.draft, hovers, problem.recording)
    least_s = problem.least_leg_s(start.draft, caps_m_s) + np.minimum(start.draft.hold_s, LEAST_HOLD_S)
    return Lateness.of(start, problem.recording, wanted_s, least_s)


def _no_changes(draft: Draft, place: int, hovers: dict[int, Hover]) -> Iterator[Draft]:
    yield from ()


def _speed_changes(draft: Draft, place: int, hovers: dict[int, Hover]) -> Iterator[Draft]:
    """The drafts that differ in how fast a place is flown to."""
    for factor in _SPEED_FACTORS:
        speeds = draft.speed_m_s.copy()
        speeds[place] = np.clip(np.round(factor * speeds[place], 2), SLOWEST_M_S, FASTEST_M_S)
        yield replace(draft, speed_m_s=speeds)


def _kind_changes(draft: Draft, place: int, hovers: dict[int, Hover]) -> Iterator[Draft]:
    """The drafts that differ in how a place is flown to, and whether it is stopped at."""
    if place in hovers:
        return
    if place == len(draft) - 1:
        yield _flipped(draft, place)
        return
    if draft.hold_s[place] > 0:
        yield _through(draft, place)
        return
    yield _flipped(draft, place)
    yield _stopped(draft, place)
    if draft.spline[place + 1]:
        yield _flipped(_flipped(draft, place) if draft.spline[place] else draft, place + 1)


def _flipped(draft: Draft, place: int) -> Draft:
    spline = draft.spline.copy()
    spline[place] = not spline[place]
    return replace(draft, spline=spline)


def _stopped(draft: Draft, place: int) -> Draft:
    """Straight to a stop."""
    spline, hold_s = draft.spline.copy(), draft.hold_s.copy()
    spline[place], hold_s[place] = False, STOP_S
    return replace(draft, spline=spline, hold_s=hold_s)


def _through(draft: Draft, place: int) -> Draft:
    """Through without a stop, on a curve."""
    spline, hold_s = draft.spline.copy(), draft.hold_s.copy()
    spline[place], hold_s[place] = True, 0.0
    return replace(draft, spline=spline, hold_s=hold_s)

"""Stops and places that make the vehicle late, left out one by one.

Steps keep all the places there are, and a vehicle that stops or turns where it need not may be late for long:
even a stop for no time takes seconds. Several in a row come of recordings that creep, in which pauses follow
one another. What to leave out is told by flying without it, where being late costs most.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.lateness import lateness_cost_m
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import Budget, FitProblem
from flight_replay.planning.fit.reference import Hover, LocalTrack
from flight_replay.planning.fit.rounds import WORTH_GOING_ON, State, flown_leaving, flown_on_schedule

_LATE_S = 0.5
"""Speeds make up for less."""
_MOST_TRIED = 8
_OVERDRAWN = 0.25
"""Flights beyond those that are enough: it is at the end of a search that a place too many shows."""


def with_fewer_places(
    problem: FitProblem, state: State, budget: Budget, least_cost: float = WORTH_GOING_ON, anew: int = 0
) -> State:
    """The best of a draft with a place less or a stop flown through; as it is if that is as good.

    Args:
        problem: what to fit; the recorded speed is to be kept.
        state: the draft as it is flown in the exact steps of ``problem``.
        budget: is told how much was flown.
        least_cost: places are tried if being late after them is at least this share of the objective.
        anew: so many changes are flown with all speeds set anew, too, as is worth it before any other step:
            a vehicle may leave sooner then what comes before a leg on which it cannot keep up.
    """
    found = state
    for tried, (draft, leave_s, hovers) in enumerate(_changes(state, problem, least_cost)):
        if not budget.affords(1, _OVERDRAWN):
            break
        with suppress(MissionError):
            best, flights = flown_leaving(problem.exact, draft, leave_s)
            budget.spend(flights)
            found = min(found, State(best, hovers), key=lambda each: each.objective_m)
            if tried < anew:
                best = flown_on_schedule(problem.exact, draft, hovers, budget)
                found = min(found, State(best, hovers), key=lambda each: each.objective_m)
    return found if found.objective_m < (1 - WORTH_GOING_ON) * state.objective_m else state


def _changes(
    state: State, problem: FitProblem, least_cost: float = WORTH_GOING_ON
) -> Iterator[tuple[Draft, Floats, dict[int, Hover]]]:
    """Changed drafts, when their places are to be left, and the hovers that they wait for."""
    draft, late_s = with_every_speed(state.best.draft), _late_s(state.best, problem.recording)
    for place in _where_late_most(state.best, problem.recording, late_s, least_cost):
        leave_s = _sooner_s(state.best.passed_s, late_s, place)
        others = np.arange(len(draft)) != place
        hovers = {at: hover for at, hover in state.hovers.items() if at != place}
        if draft.hold_s[place] > 0:
            through = replace(draft, hold_s=draft.hold_s * others, spline=draft.spline | ~others)
            yield _left_straight(through, problem), leave_s, hovers
        yield _left_straight(draft.select(others), problem), leave_s[others], _without(place, hovers)


def _left_straight(draft: Draft, problem: FitProblem) -> Draft:
    """A draft whose stops are left on straight legs, if they have to be."""
    if not problem.straight_starts:
        return draft
    from_rest = np.append(False, draft.hold_s[:-1] > 0)
    return replace(draft, spline=draft.spline & ~from_rest)


def _without(place: int, hovers: Mapping[int, Hover]) -> dict[int, Hover]:
    """The hovers by the places that there are without one of them."""
    return {at - (at > place): hover for at, hover in hovers.items()}


def _late_s(evaluation: Evaluation, recording: LocalTrack) -> Floats:
    """How much later than the recording the vehicle leaves each place (n,)."""
    fix = np.searchsorted(evaluation.flown_s, evaluation.passed_s).clip(max=len(recording) - 1)
    return np.asarray((evaluation.flown_s - recording.time_s)[fix])


def _sooner_s(passed_s: Floats, late_s: Floats, place: int) -> Floats:
    """When to leave places (n,): from ``place`` on as recorded, up to where the vehicle is on time again."""
    late = late_s > _LATE_S
    late[:place] = False
    late[place:] = np.logical_and.accumulate(late[place:])
    return np.maximum.accumulate(passed_s - np.where(late, late_s, 0.0))


def _where_late_most(
    evaluation: Evaluation, recording: LocalTrack, late_s: Floats, least_cost: float
) -> list[int]:
    """The places, not the ends, after which it costs most that the vehicle is late, until it is no more."""
    costs_m = evaluation.time_share * lateness_cost_m(evaluation.late_m) / len(recording)
    on_time = evaluation.flown_s - recording.time_s <= _LATE_S
    found: list[tuple[float, int]] = []
    for place in np.flatnonzero(late_s[1:-1] > _LATE_S) + 1:
        since = int(np.searchsorted(evaluation.flown_s, evaluation.passed_s[place]))
        until = since + int(np.argmax(np.append(on_time[since:], True)))
        found.append((-float(costs_m[since:until].sum()), int(place)))
    found = [each for each in sorted(found) if -each[0] > least_cost * evaluation.objective_m]
    return [place for _, place in found[:_MOST_TRIED]]

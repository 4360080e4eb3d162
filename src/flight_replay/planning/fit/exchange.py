"""Stretches exchanged between drafts of the same recording: one is better here, another there.

A draft that a search ends with is nowhere worse than its neighbours, but in some stretch another search
has found something better. Where two drafts meet, at about the same place when the recording was there,
one can go on as the other does up to where they meet again. What that gains by the errors along both is
only a guess, as the vehicle comes into the stretch otherwise than before: it is flown to be known.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.objective import Evaluation, leg_costs_m, scales_of
from flight_replay.planning.fit.problem import Budget, FitProblem
from flight_replay.planning.fit.rounds import FIRST_DAMPING, State
from flight_replay.planning.fit.speed_schedule import with_speeds

_NEAR_S, _NEAR_M = 1.5, 2.0
_LEAST_GAIN_M = 0.003
_ALIKE = 4
"""Stretches whose ends are fewer places apart together are tried once."""
_TRIES = 5
_ROUNDS = 2


@dataclass(frozen=True, slots=True)
class _Stretch:
    """From where two drafts meet to where they meet again: places of the one, and of the other."""

    first: int
    last: int
    other_first: int
    other_last: int


def exchanged(problem: FitProblem, states: Sequence[State], most: int, budget: Budget) -> State:
    """The best that comes of some drafts by exchanging stretches between them.

    Args:
        problem: what to fit, in the steps in which the drafts were evaluated.
        states: the drafts.
        most: how many places there may be.
        budget: is told how much was flown.
    """
    best = min(states, key=lambda state: state.best.objective_m)
    for _ in range(_ROUNDS):
        before_m = best.best.objective_m
        for other in states:
            best = _with_stretch_of(problem, best, other, most, budget)
        if best.best.objective_m >= before_m:
            break
    return best


def _with_stretch_of(problem: FitProblem, state: State, other: State, most: int, budget: Budget) -> State:
    """The best after exchanging stretches for those of another draft, one after another while that gains."""
    while True:
        found = state
        for stretch in islice(_promising(problem, state, other, most), _TRIES):
            if not budget.affords(1):
                break
            budget.spend(1)
            trial = _spliced(problem, state, other, stretch)
            found = min(found, trial, key=lambda each: each.best.objective_m)
        if found is state:
            return state
        state = found


def _promising(problem: FitProblem, state: State, other: State, most: int) -> Iterator[_Stretch]:
    """The stretches that the other draft seems better in, the best first, none much like one before."""
    here, there = _meetings(problem, state, other)
    scales_m = scales_of(state.best)
    costs, other_costs = (
        np.cumsum(leg_costs_m(each.best, scales_m, whole=True))[at]
        for each, at in ((state, here), (other, there))
    )
    saved = costs - other_costs
    gain = saved[None, :] - saved[:, None]
    longer = (there[None, :] - there[:, None]) - (here[None, :] - here[:, None])
    in_order = (here[None, :] > here[:, None]) & (there[None, :] > there[:, None])
    possible = in_order & (gain > _LEAST_GAIN_M) & (len(state.best.draft) + longer <= most)
    begins, ends = possible.nonzero()
    order = np.argsort(-gain[begins, ends], kind="stable")
    tried: list[tuple[int, int]] = []
    for begin, end in zip(begins[order].tolist(), ends[order].tolist(), strict=True):
        first, last = int(here[begin]), int(here[end])
        if all(abs(first - a) + abs(last - b) >= _ALIKE for a, b in tried):
            tried.append((first, last))
            yield _Stretch(first, last, int(there[begin]), int(there[end]))


def _meetings(problem: FitProblem, state: State, other: State) -> tuple[Indices, Indices]:
    """Places (k,) of a draft, rising, and for each the nearest of another's at about the same time."""
    apart_m = np.linalg.norm(state.best.draft.places_m[:, None] - other.best.draft.places_m, axis=2)
    passing_s, other_passing_s = (_recorded_s(problem, each.best) for each in (state, other))
    apart_s = np.abs(passing_s[:, None] - other_passing_s)
    stops, other_stops = (_stops(each) for each in (state, other))
    meet = (apart_m < _NEAR_M) & (apart_s < _NEAR_S) & (stops[:, None] == other_stops)
    here = meet.any(axis=1).nonzero()[0]
    return here, np.where(meet, apart_m, np.inf)[here].argmin(axis=1)


def _recorded_s(problem: FitProblem, evaluation: Evaluation) -> Floats:
    """When the recording was where the planned path comes to each place (n,)."""
    fixes = evaluation.planned[0]
    progress = np.maximum.accumulate(fixes.leg + fixes.part) + 1e-9 * np.arange(len(fixes.leg))
    return np.interp(np.arange(1, len(evaluation.draft) + 1), progress, problem.recording.time_s)


def _stops(state: State) -> Indices:
    """0 for each place (n,) that is flown through, 1 for a stop, 2 where a recorded hover is waited for."""
    stops = (state.best.draft.hold_s > 0).astype(np.intp)
    stops[list(state.hovers)] = 2
    return stops


def _spliced(problem: FitProblem, state: State, other: State, stretch: _Stretch) -> State:
    """The one draft with the other's places in a stretch, as it is flown."""
    mine, its = with_every_speed(state.best.draft), with_every_speed(other.best.draft)
    parts = [
        mine.part(0, stretch.first + 1),
        its.part(stretch.other_first + 1, stretch.other_last + 1),
        mine.part(stretch.last + 1, len(mine)),
    ]
    draft = Draft(
        np.concatenate([part.places_m for part in parts]),
        np.concatenate([part.spline for part in parts]),
        np.concatenate([part.hold_s for part in parts]),
        np.concatenate([part.speed_m_s for part in parts]),
    )
    in_stretch = stretch.first - stretch.other_first
    behind = in_stretch + stretch.other_last - stretch.last
    hovers = {place: hover for place, hover in state.hovers.items() if place <= stretch.first}
    for place, hover in other.hovers.items():
        if stretch.other_first < place <= stretch.other_last:
            hovers[place + in_stretch] = hover
    hovers |= {place + behind: hover for place, hover in state.hovers.items() if place > stretch.last}
    evaluation = problem.evaluate(with_speeds(draft, draft.speed_m_s))
    return replace(state, best=evaluation, hovers=hovers, damping=FIRST_DAMPING)

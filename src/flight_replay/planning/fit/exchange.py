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
from flight_replay.planning.fit.reference import Hover
from flight_replay.planning.fit.rounds import FIRST_DAMPING, State
from flight_replay.planning.fit.speed_schedule import with_speeds

_NEAR_S, _NEAR_M = 1.5, 2.0
_LEAST_GAIN_M = 0.003
_ALIKE = 4
"""Stretches whose ends are fewer places apart together are tried once."""
_LOOKED_AT = 300
"""So many stretches of most promise are looked at closer."""
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
        for stretches in islice(_promising(problem, state, other, most), _TRIES):
            if not budget.affords(1):
                break
            budget.spend(1)
            trial = _spliced(problem, state, other, stretches)
            found = min(found, trial, key=lambda each: each.best.objective_m)
        if found is state:
            return state
        state = found


def _promising(problem: FitProblem, state: State, other: State, most: int) -> Iterator[tuple[_Stretch, ...]]:
    """The stretches that the other draft seems better in, the best first, none much like one before.

    One with more places than there is room for comes with a second, behind or before it, that has less.
    """
    stretches = _Stretches.between(problem, state, other)
    room = most - len(state.best.draft)
    found: list[tuple[float, list[int]]] = []
    for row in np.argsort(-stretches.gain_m, kind="stable")[:_LOOKED_AT].tolist():
        rows = [row] if stretches.longer[row] <= room else stretches.with_shorter(row, room)
        gain_m = float(stretches.gain_m[rows].sum()) if rows else 0.0
        if gain_m > _LEAST_GAIN_M:
            found.append((gain_m, rows))
    tried: list[tuple[int, int]] = []
    for _, rows in sorted(found, key=lambda each: -each[0]):
        first, last = int(stretches.first[rows[0]]), int(stretches.last[rows[0]])
        if all(abs(first - a) + abs(last - b) >= _ALIKE for a, b in tried):
            tried.append((first, last))
            yield tuple(stretches.row(each) for each in rows)


@dataclass(frozen=True, slots=True, eq=False)
class _Stretches:
    """All k that there are between two drafts: their ends (k,), what is gained, and how many places more."""

    first: Indices
    last: Indices
    other_first: Indices
    other_last: Indices
    gain_m: Floats

    @property
    def longer(self) -> Indices:
        """How many places more there are with each."""
        return (self.other_last - self.other_first) - (self.last - self.first)

    @classmethod
    def between(cls, problem: FitProblem, state: State, other: State) -> _Stretches:
        """Those of two drafts."""
        here, there = _meetings(problem, state, other)
        scales_m = scales_of(state.best)
        costs, other_costs = (
            np.cumsum(leg_costs_m(each.best, scales_m, whole=True))[at]
            for each, at in ((state, here), (other, there))
        )
        saved = costs - other_costs
        in_order = (here[None, :] > here[:, None]) & (there[None, :] > there[:, None])
        begins, ends = in_order.nonzero()
        return cls(here[begins], here[ends], there[begins], there[ends], saved[ends] - saved[begins])

    def with_shorter(self, row: int, room: int) -> list[int]:
        """A stretch, and the best of those beside it with which there is room for it; none without one."""
        apart = (self.first >= self.last[row]) | (self.last <= self.first[row])
        fitting = np.flatnonzero(apart & (self.longer + self.longer[row] <= room))
        if not len(fitting):
            return []
        return [row, int(fitting[self.gain_m[fitting].argmax()])]

    def row(self, row: int) -> _Stretch:
        """One of them."""
        columns = (self.first, self.last, self.other_first, self.other_last)
        return _Stretch(*(int(column[row]) for column in columns))


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


def _spliced(problem: FitProblem, state: State, other: State, stretches: tuple[_Stretch, ...]) -> State:
    """The one draft with the other's places in some stretches, as it is flown."""
    draft, hovers = with_every_speed(state.best.draft), state.hovers
    for stretch in sorted(stretches, key=lambda each: -each.first):
        draft, hovers = _with_places_of(draft, hovers, other, stretch)
    evaluation = problem.evaluate(with_speeds(draft, draft.speed_m_s))
    return replace(state, best=evaluation, hovers=hovers, damping=FIRST_DAMPING)


def _with_places_of(
    draft: Draft, hovers: dict[int, Hover], other: State, stretch: _Stretch
) -> tuple[Draft, dict[int, Hover]]:
    """A draft, and the hovers that it waits for, with another's places in a stretch."""
    its = with_every_speed(other.best.draft)
    parts = [
        draft.part(0, stretch.first + 1),
        its.part(stretch.other_first + 1, stretch.other_last + 1),
        draft.part(stretch.last + 1, len(draft)),
    ]
    in_stretch = stretch.first - stretch.other_first
    behind = in_stretch + stretch.other_last - stretch.last
    found = {place: hover for place, hover in hovers.items() if place <= stretch.first}
    for place, hover in other.hovers.items():
        if stretch.other_first < place <= stretch.other_last:
            found[place + in_stretch] = hover
    found |= {place + behind: hover for place, hover in hovers.items() if place > stretch.last}
    joined = Draft(
        np.concatenate([part.places_m for part in parts]),
        np.concatenate([part.spline for part in parts]),
        np.concatenate([part.hold_s for part in parts]),
        np.concatenate([part.speed_m_s for part in parts]),
    )
    return joined, found

"""Stretches exchanged between drafts of the same recording: one is better here, another there.

A draft that a search ends with is nowhere worse than its neighbours, but in some stretch another search
has found something better. Where two drafts meet, at about the same place when the recording was there,
one can go on as the other does. So all that can be made of some drafts are chains of their legs. What legs
cost after those of another draft is only a guess, as the vehicle comes to them otherwise than before: the
cheapest chain is flown, what it costs more than it was expected to becomes the price of going from draft to
draft there, and then another may be the cheapest. That is lazy search (Dellin and Srinivasa, 2016).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.planning.fit.chains.cheapest_chain import Links, cheapest_chain
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.objective import Evaluation, leg_costs_m, scales_of
from flight_replay.planning.fit.problem import Budget, FitProblem
from flight_replay.planning.fit.rounds import FIRST_DAMPING, State, flown_on_time
from flight_replay.planning.fit.speed_schedule import Schedule, speed_caps_m_s, with_speeds

_NEAR_S, _NEAR_M = 1.5, 2.0
_PRICE_M, _PRICE_AT_STOP_M = 0.004, 0.001
"""What going on as another draft is expected to cost at least, flying through and from a stop."""
_PRICE_M_S2 = 0.03
"""What it costs besides by the square of how much sooner or later the other draft is there."""
_MOST_CHAINS = 6
_LEAST_GAIN_M = 0.002


def exchanged(problem: FitProblem, states: Sequence[State], most: int, budget: Budget) -> State:
    """The best that comes of some drafts by exchanging stretches between them.

    Args:
        problem: what to fit, in the steps in which the drafts were evaluated.
        states: the drafts, at least one of at most ``most`` places; others may have more.
        most: how many places what comes of them may have.
        budget: is told how much was flown.
    """
    best = min((state for state in states if len(state.best.draft) <= most), key=_objective_m)
    legs = _Legs.of(problem, states)
    for _ in range(_MOST_CHAINS):
        chain = legs.cheapest_chain(most)
        too_much_m = float(legs.costs_m(best.best).sum()) - _LEAST_GAIN_M
        if legs.is_one_draft(chain) or legs.expected_m(chain) >= too_much_m or not budget.affords(1):
            break
        trial = _joined(problem, states, legs.rows(chain), budget)
        legs.learn(chain, trial.best)
        best = min(best, trial, key=_objective_m)
    return best


def _objective_m(state: State) -> float:
    return state.best.objective_m


@dataclass(frozen=True, slots=True, eq=False)
class _Legs:
    """The legs of some drafts, n together, and where one draft can go on as another."""

    draft: Indices
    place: Indices
    cost_m: Floats
    passing_s: Floats
    links: Links
    scales_m: tuple[float, float]

    @classmethod
    def of(cls, problem: FitProblem, states: Sequence[State]) -> _Legs:
        """Those of drafts as they are flown."""
        lengths = [len(state.best.draft) for state in states]
        scales_m = scales_of(min(states, key=_objective_m).best)
        passing_s = [_recorded_s(problem, state.best) for state in states]
        return cls(
            np.repeat(np.arange(len(states)), lengths),
            np.concatenate([np.arange(length) for length in lengths]),
            np.concatenate([leg_costs_m(state.best, scales_m, whole=True) for state in states]),
            np.concatenate(passing_s),
            _links(states, passing_s, timed=problem.timed),
            scales_m,
        )

    def costs_m(self, evaluation: Evaluation) -> Floats:
        """What the legs of a draft (n,) cost, by the same measure."""
        return leg_costs_m(evaluation, self.scales_m, whole=True)

    def cheapest_chain(self, most: int) -> Indices:
        """The legs of the chain of at most ``most`` places that is expected to be the cheapest."""
        return cheapest_chain(self.place, self.cost_m, self.passing_s, self.links, most)

    def rows(self, chain: Indices) -> list[tuple[int, int]]:
        """The draft of each leg of a chain, and the place that it leads to."""
        return list(zip(self.draft[chain].tolist(), self.place[chain].tolist(), strict=True))

    def is_one_draft(self, chain: Indices) -> bool:
        """Whether a chain is a draft as it is."""
        return not self._changes(chain)

    def expected_m(self, chain: Indices) -> float:
        """What a chain is expected to cost."""
        links = [link for _, link in self._changes(chain)]
        return float(self.cost_m[chain].sum() + self.links.price[links].sum())

    def learn(self, chain: Indices, flown: Evaluation) -> None:
        """Take what a chain costs more, as it is flown, for the prices of the links that it takes."""
        more_m = self.costs_m(flown) - self.cost_m[chain]
        changes = self._changes(chain)
        begins = [0, *(at - 1 for at, _ in changes[1:]), len(chain)]
        for (begin, end), (_, link) in zip(pairwise(begins), changes, strict=True):
            self.links.price[link] = max(0.0, float(more_m[begin:end].sum()))

    def _changes(self, chain: Indices) -> list[tuple[int, int]]:
        """After which legs of a chain it goes on as another draft, and by which link."""
        return [
            (at, int(np.flatnonzero((self.links.here == here) & (self.links.there == next_leg - 1))[0]))
            for at, (here, next_leg) in enumerate(pairwise(chain.tolist()))
            if next_leg != here + 1
        ]


def _links(states: Sequence[State], passing_s: list[Floats], *, timed: bool) -> Links:
    """From each place to the nearest of each other draft's that it meets, both by their legs."""
    begins = np.cumsum([0, *(len(state.best.draft) for state in states)]).tolist()
    here, there, price_m = [np.empty(0, np.intp)], [np.empty(0, np.intp)], [np.empty(0)]
    for k, state in enumerate(states):
        for m, other in enumerate(states):
            if k == m:
                continue
            places, others = _meetings(state, other, np.abs(passing_s[k][:, None] - passing_s[m]))
            here.append(begins[k] + places)
            there.append(begins[m] + others)
            price_m.append(_prices_m(state, other, places, others, timed=timed))
    return Links(np.concatenate(here), np.concatenate(there), np.concatenate(price_m))


def _meetings(state: State, other: State, apart_s: Floats) -> tuple[Indices, Indices]:
    """Places (k,) of a draft, rising, and for each the nearest of another's at about the same time."""
    apart_m = np.linalg.norm(state.best.draft.places_m[:, None] - other.best.draft.places_m, axis=2)
    meet = (apart_m < _NEAR_M) & (apart_s < _NEAR_S) & (_stops(state)[:, None] == _stops(other))
    here = meet.any(axis=1).nonzero()[0]
    return here, np.where(meet, apart_m, np.inf)[here].argmin(axis=1)


def _prices_m(state: State, other: State, places: Indices, others: Indices, *, timed: bool) -> Floats:
    """What going on from places of one draft as from those of another may cost (k,)."""
    at_stop = state.best.draft.hold_s[places] > 0
    least_m = np.where(at_stop, _PRICE_AT_STOP_M, _PRICE_M)
    if not timed:
        return least_m
    later_s = state.best.passed_s[places] - other.best.passed_s[others]
    later_s -= np.where(at_stop, np.round(later_s), 0.0)
    return np.asarray(least_m + _PRICE_M_S2 * later_s**2)


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


def _joined(
    problem: FitProblem, states: Sequence[State], rows: list[tuple[int, int]], budget: Budget
) -> State:
    """A chain of drafts' places, as it is flown: at the times at which each draft passes its own."""
    drafts = [with_every_speed(state.best.draft) for state in states]
    parts = [drafts[k].part(place, place + 1) for k, place in rows]
    hold_s = np.concatenate([part.hold_s for part in parts])
    passed_s = np.array([states[k].best.passed_s[place] for k, place in rows])
    for at, ((k, _), (m, place)) in enumerate(pairwise(rows)):
        if problem.timed and k != m and hold_s[at] > 0:
            leaves_s = float(states[m].best.passed_s[place - 1])
            hold_s[at] = max(1.0, hold_s[at] + round(leaves_s - passed_s[at]))
            passed_s[at] = leaves_s
    joined = Draft(
        np.concatenate([part.places_m for part in parts]),
        np.concatenate([part.spline for part in parts]),
        hold_s,
        np.concatenate([part.speed_m_s for part in parts]),
    )
    best = _flown(problem, joined, np.maximum.accumulate(passed_s), budget)
    hovers = {at: states[k].hovers[place] for at, (k, place) in enumerate(rows) if place in states[k].hovers}
    return replace(states[0], best=best, hovers=hovers, damping=FIRST_DAMPING)


def _flown(problem: FitProblem, draft: Draft, leave_s: Floats, budget: Budget) -> Evaluation:
    if not problem.timed:
        budget.spend(1)
        return problem.evaluate(with_speeds(draft, draft.speed_m_s))
    caps_m_s = speed_caps_m_s(draft, problem.recording)
    found, steps = flown_on_time(problem, Schedule(draft, leave_s), caps_m_s)
    budget.spend(1 + steps * problem.step_s / max(float(found.flight.time_s[-1]), problem.step_s))
    return found

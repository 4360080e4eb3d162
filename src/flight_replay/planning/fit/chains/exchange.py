"""Stretches exchanged between drafts of the same recording: one is better here, another there.

A draft that a search ends with is nowhere worse than its neighbours, but in some stretch another search
has found something better. Where two drafts meet, at about the same place when the recording was there,
one can go on as the other does. So all that can be made of some drafts are chains of their legs. What the
legs around a change cost on paper, where their curves are others then, can be told. What they cost in flight
is a guess, as the vehicle comes to them otherwise than before: the cheapest chain is flown, what it costs
more than it was expected to becomes the price of going from draft to draft there, and then another may be
the cheapest. That is lazy search (Dellin and Srinivasa, 2016).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flight_replay.planning.fit.chains.draft_legs import DraftLegs
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.problem import Budget, FitProblem
from flight_replay.planning.fit.reference import LEAST_HOLD_S
from flight_replay.planning.fit.rounds import FIRST_DAMPING, State, flown_leaving

_MOST_CHAINS = 12
EXCHANGE_FLIGHTS = 20
"""What an exchange takes about, at the recorded speed."""
_LEAST_GAIN_M = 0.002


def exchanged(problem: FitProblem, states: Sequence[State], most: int, budget: Budget) -> State:
    """The best that comes of some drafts by exchanging stretches between them.

    Args:
        problem: what to fit, in the steps in which the drafts were evaluated.
        states: the drafts, at least one of at most ``most`` places; others may have more.
        most: how many places what comes of them may have.
        budget: is told how much was flown.
    """
    small_enough = (state for state in states if len(state.best.draft) <= most)
    best = min(small_enough, key=lambda state: state.objective_m)
    legs = DraftLegs.of(problem, states)
    for _ in range(_MOST_CHAINS):
        chain = legs.cheapest_chain(most)
        too_much_m = float(legs.costs.costs_m(best.best).sum()) - _LEAST_GAIN_M
        if legs.is_one_draft(chain) or legs.expected_m(chain) >= too_much_m or not budget.affords(1):
            break
        trial = _joined(problem, states, legs.rows(chain), budget)
        legs.learn(chain, trial.best)
        best = min(best, trial, key=lambda state: state.objective_m)
    return best


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
            hold_s[at] = max(LEAST_HOLD_S, hold_s[at] + round(leaves_s - passed_s[at]))
            passed_s[at] = leaves_s
    joined = Draft(
        np.concatenate([part.places_m for part in parts]),
        np.concatenate([part.spline for part in parts]),
        hold_s,
        np.concatenate([part.speed_m_s for part in parts]),
    )
    best, flights = flown_leaving(problem, joined, np.maximum.accumulate(passed_s))
    budget.spend(flights)
    hovers = {at: states[k].hovers[place] for at, (k, place) in enumerate(rows) if place in states[k].hovers}
    return replace(states[0], best=best, hovers=hovers, damping=FIRST_DAMPING)

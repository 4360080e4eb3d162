"""Where drafts meet, so that one can go on as another, and what that may cost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.planning.fit.chains.cheapest_chain import Links
from flight_replay.planning.fit.chains.curve_prices import CurvePrices
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.rounds import State

_NEAR_S, _NEAR_M = 1.5, 2.0
_PRICE_M, _PRICE_AT_STOP_M = 0.004, 0.001
"""What going on as another draft is expected to cost at least, flying through and from a stop."""
_PRICE_M_S2 = 0.03
"""What it costs besides by the square of how much sooner or later the other draft is there."""


def recorded_s(problem: FitProblem, evaluation: Evaluation) -> Floats:
    """When the recording was where the planned path comes to each place (n,)."""
    return evaluation.planned[0].passing_s(len(evaluation.draft), problem.recording.time_s)


def links_between(problem: FitProblem, states: Sequence[State], path_share: float) -> Links:
    """From each place to the nearest of each other draft's that it meets, both by their legs.

    Args:
        problem: what to fit.
        states: the drafts as they are flown.
        path_share: what the objective changes by the mean of fourth powers of distances.
    """
    passing_s = [recorded_s(problem, state.best) for state in states]
    begins = np.cumsum([0, *map(len, passing_s)]).tolist()
    here, there, price_m = [np.empty(0, np.intp)], [np.empty(0, np.intp)], [np.empty(0)]
    for k, state in enumerate(states):
        for m, other in enumerate(states):
            if k == m:
                continue
            places, others = _meetings(state, other, np.abs(passing_s[k][:, None] - passing_s[m]))
            here.append(begins[k] + places)
            there.append(begins[m] + others)
            price_m.append(_prices_m(state, other, places, others, timed=problem.timed))
    drafts = [state.best.draft for state in states]
    curves = CurvePrices(problem.recording, drafts, np.concatenate(passing_s), path_share)
    legs, others = np.concatenate(here), np.concatenate(there)
    return Links(legs, others, np.concatenate(price_m) + curves.prices_m(legs, others))


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


def _stops(state: State) -> Indices:
    """0 for each place (n,) that is flown through, 1 for a stop, 2 where a recorded hover is waited for."""
    stops = (state.best.draft.hold_s > 0).astype(np.intp)
    stops[list(state.hovers)] = 2
    return stops

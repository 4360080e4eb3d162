"""From first drafts to the best at the vehicle's own speed: move the places, change the legs, and again."""

from __future__ import annotations

from flight_replay.planning.fit.chains.exchange import exchanged
from flight_replay.planning.fit.objective import Evaluation, objective_lower_bound_m
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.rounds import (
    ENOUGH,
    NO_MORE,
    ROUND_FLIGHTS,
    SWEEP_FLIGHTS,
    WORTH_GOING_ON,
    State,
    begun,
    polished,
    refined,
    swept,
)
from flight_replay.planning.fit.timed_search import timed_search

_STEPS = 5
_SEARCH_FLIGHTS = 1.5 * SWEEP_FLIGHTS
_HOPELESS = 1.5
"""A start so many times worse than the best does not get a round."""


def search(
    problem: FitProblem, starts: list[FirstDraft], most: int, budget: Budget
) -> tuple[Evaluation, str]:
    """The best draft of at most ``most`` places that comes of some starts, and why the search stopped.

    The first of them has no more places.
    """
    found = (timed_search if problem.timed else _untimed_search)(problem, starts, most, budget)
    budget.finish()
    return found


def _untimed_search(
    problem: FitProblem, starts: list[FirstDraft], most: int, budget: Budget
) -> tuple[Evaluation, str]:
    """The best that comes of the first of some starts, and of the next while there is time, and why it ends.

    The first may be a dead end, as straight legs often are. What was found exchanges stretches.
    """
    first, *others = _begun(problem, starts, budget)
    state, stopped = _searched(problem, first, budget)
    found = [state]
    for start in others:
        best_m = min(map(_objective_m, found))
        if start.best.objective_m < _HOPELESS * best_m and budget.affords(_SEARCH_FLIGHTS):
            state, stopped = _searched(problem, start, budget)
            found.append(state)
    return polished(problem, exchanged(problem, found, most, budget), budget).best, stopped


def _objective_m(state: State) -> float:
    return state.best.objective_m


def _begun(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> list[State]:
    """The starts after a first round, but for the hopeless ones, the best first."""
    states = [begun(problem, starts[0], budget)]
    for start in starts[1:]:
        best_m = min(map(_objective_m, states))
        least_m = objective_lower_bound_m(start.draft, problem.recording)
        if least_m < best_m and budget.affords(ROUND_FLIGHTS):
            states.append(begun(problem, start, budget, _HOPELESS * best_m))
    return sorted(states, key=_objective_m)


def _searched(problem: FitProblem, state: State, budget: Budget) -> tuple[State, str]:
    """The best of places moved, and of legs changed one by one between that; and why it ends."""
    while budget.affords(SWEEP_FLIGHTS):
        before_m = state.best.objective_m
        state = refined(problem, polished(problem, state, budget), budget, _STEPS)
        state = polished(problem, swept(problem, state, budget), budget)
        if state.best.objective_m > (1 - WORTH_GOING_ON) * before_m:
            return state, NO_MORE
    return state, ENOUGH

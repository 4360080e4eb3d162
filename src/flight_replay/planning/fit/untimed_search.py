"""A search at the vehicle's own speed: the places moved, the legs changed one by one, and again."""

from __future__ import annotations

from math import inf

from flight_replay.planning.fit.chains.exchange import EXCHANGE_FLIGHTS
from flight_replay.planning.fit.objective import objective_lower_bound_m
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.rounds import (
    HOPELESS,
    MOVING_FLIGHTS,
    SWEEP_FLIGHTS,
    WORTH_GOING_ON,
    State,
    hopeful,
    polished,
    refined,
    rounded,
    state_of,
    swept,
)

_STEPS = 5
ANOTHER_FLIGHTS = 1.5 * SWEEP_FLIGHTS
"""What it takes at least to go on with another start."""
_BEGINNING_FLIGHTS = MOVING_FLIGHTS + EXCHANGE_FLIGHTS + ANOTHER_FLIGHTS
"""What it takes at least to begin with another start."""


def begun(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> list[State]:
    """As many of the starts as may go on, after a first round, but for the hopeless ones."""
    states: list[State] = []
    for start in starts:
        best_m = min((state.objective_m for state in states), default=inf)
        least_m = objective_lower_bound_m(start.draft, problem.recording)
        if states and (least_m >= best_m or not budget.affords(_BEGINNING_FLIGHTS)):
            continue
        state = state_of(problem, start, budget)
        if state.objective_m <= HOPELESS * best_m and budget.affords(MOVING_FLIGHTS):
            state = rounded(problem, state, budget)
        states.append(state)
    return hopeful(states)


def gone_on(problem: FitProblem, state: State, budget: Budget) -> State:
    """The best of places moved, and of legs changed one by one between that, while that gains."""
    while budget.affords(SWEEP_FLIGHTS):
        before_m = state.objective_m
        state = refined(problem, polished(problem, state, budget), budget, _STEPS)
        state = polished(problem, swept(problem, state, budget), budget)
        if state.objective_m > (1 - WORTH_GOING_ON) * before_m:
            break
    return polished(problem, state, budget)

"""A search at the vehicle's own speed: steps of all places, the legs changed one by one, and again."""

from __future__ import annotations

from math import inf

from flight_replay.planning.fit.chains.exchange import EXCHANGE_FLIGHTS
from flight_replay.planning.fit.draft import with_straight_climbs
from flight_replay.planning.fit.objective import objective_lower_bound_m
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.rounds import (
    MOVING_FLIGHTS,
    SWEEP_FLIGHTS,
    WORTH_GOING_ON,
    State,
    better,
    flown,
    polished,
    rounded_hopeful,
    swept,
)
from flight_replay.planning.fit.steps.joint_steps import stepped

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
        if best_m == inf or (least_m < best_m and budget.affords(_BEGINNING_FLIGHTS)):
            found, straight = flown(problem, start.draft, budget), with_straight_climbs(start.draft)
            if straight is not start.draft:
                found = better(found, flown(problem, straight, budget))
            states.append(State(found, start.hovers))
    return rounded_hopeful(problem, states, budget, MOVING_FLIGHTS, _BEGINNING_FLIGHTS)


def gone_on(problem: FitProblem, state: State, budget: Budget) -> State:
    """After steps of all places, and of legs changed one by one between them, while that gains."""
    state = stepped(problem, polished(problem, state, budget), budget)
    while budget.affords(SWEEP_FLIGHTS):
        before_m, after = state.objective_m, swept(problem, state, budget)
        if after.best is state.best:
            break
        state = stepped(problem, after, budget)
        if state.objective_m > (1 - WORTH_GOING_ON) * before_m:
            break
    return state

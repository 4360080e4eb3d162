"""A search where the recorded speed is to be kept: steps of all speeds and places together.

What is found in steps of the model that are long enough to be cheap is judged in exact ones. In the end it is
timed in those of the autopilot: in steps of 20 ms a leg may be milliseconds off, and all later ones with it.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

from flight_replay.exceptions import MissionError
from flight_replay.planning.fit.chains.exchange import EXCHANGE_FLIGHTS
from flight_replay.planning.fit.draft import with_straight_climbs
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.rounds import (
    FIRST_DAMPING,
    ROUND_FLIGHTS,
    TIMED_FLIGHTS,
    WORTH_GOING_ON,
    State,
    flown_leaving,
    flown_on_schedule,
    hopeful,
    rounded_hopeful,
)
from flight_replay.planning.fit.steps.joint_steps import JOINT_FLIGHTS, stepped

_GOING_ON_FLIGHTS = 3 * JOINT_FLIGHTS
_BEGINNING_FLIGHTS = ROUND_FLIGHTS + EXCHANGE_FLIGHTS + _GOING_ON_FLIGHTS
"""What it takes at least to begin with another start."""
ANOTHER_FLIGHTS = 2 * JOINT_FLIGHTS
"""What it takes at least to go on with another start."""


def begun(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> list[State]:
    """As many of the starts as may go on, after a first round and a step, in exact steps of the model."""
    return _stepped_once(problem, _rounded(problem, starts, budget), budget)


def _rounded(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> list[State]:
    """As many of the starts as may go on, after a first round; those compared are as far."""
    states: list[State] = []
    for start in starts:
        some_stay_up = any(state.best.flight.stays_up for state in states)
        if not some_stay_up or budget.affords(_BEGINNING_FLIGHTS):
            on_time = flown_on_schedule(problem, start.draft, start.hovers, budget)
            if not on_time.flight.stays_up:
                straight = with_straight_climbs(start.draft)
                on_time = flown_on_schedule(problem, straight, start.hovers, budget)
            states.append(State(on_time, start.hovers))
    return rounded_hopeful(problem, states, budget, ROUND_FLIGHTS, _BEGINNING_FLIGHTS)


def _stepped_once(problem: FitProblem, states: list[State], budget: Budget) -> list[State]:
    """The states in exact steps of the model, after a step each where there is time for that."""
    states = hopeful([replace(state, best=problem.exact.evaluate(state.best.draft)) for state in states])
    if not budget.affords(len(states) * JOINT_FLIGHTS + EXCHANGE_FLIGHTS + _GOING_ON_FLIGHTS):
        return states
    return [stepped(problem, state, budget, most=1) for state in states]


def gone_on(problem: FitProblem, state: State, budget: Budget) -> State:
    """After as many steps as lead further, and the speeds set anew between them, while that gains."""
    state = stepped(problem, state, budget)
    while budget.affords(TIMED_FLIGHTS + JOINT_FLIGHTS):
        before_m = state.objective_m
        on_time = flown_on_schedule(problem.exact, state.best.draft, state.hovers, budget)
        anew = replace(state, best=on_time, damping=FIRST_DAMPING)
        state = min(state, stepped(problem, anew, budget), key=lambda each: each.objective_m)
        if state.objective_m > (1 - WORTH_GOING_ON) * before_m:
            break
    return state


def timed_finely(problem: FitProblem, best: Evaluation) -> Evaluation:
    """A draft with its speeds set anew, so that each place is left when it was, in steps as on board."""
    found = problem.on_board.evaluate(best.draft)
    with suppress(MissionError):
        anew, _ = flown_leaving(problem.on_board, best.draft, best.passed_s)
        found = min(found, anew, key=lambda each: each.objective_m)
    return found

"""From first drafts to the best where the recorded speed is to be kept.

Which waypoints a draft begins with decides where a search ends, and little that can be seen before tells
which are good. So there are several starts. They exchange stretches, and what comes of that goes on as far as
steps of all speeds and places together lead. So do the others, one by one, while there is time, each
exchanging with the best. What is found in steps of the model that are long enough to be cheap is judged in
exact ones.
"""

from __future__ import annotations

from dataclasses import replace

from flight_replay.planning.fit.chains.exchange import exchanged
from flight_replay.planning.fit.joint_steps import JOINT_FLIGHTS, stepped_jointly
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.rounds import (
    ENOUGH,
    FIRST_DAMPING,
    NO_MORE,
    ROUND_FLIGHTS,
    TIMED_FLIGHTS,
    WORTH_GOING_ON,
    State,
    rounded,
    timed,
)

_MANY_STEPS = 100
_EXCHANGE_FLIGHTS = 20
_GOING_ON_FLIGHTS = 5 * JOINT_FLIGHTS
_BEGINNING_FLIGHTS = ROUND_FLIGHTS + _EXCHANGE_FLIGHTS + _GOING_ON_FLIGHTS
"""What it takes at least to begin with another start."""
_ANOTHER_FLIGHTS = 3 * JOINT_FLIGHTS
"""What it takes at least to go on with another start."""
_HOPELESS = 1.5
"""A start so many times worse than the best before its first round, or after it, goes no further."""


def timed_search(
    problem: FitProblem, starts: list[FirstDraft], most: int, budget: Budget
) -> tuple[Evaluation, str]:
    """The best draft of at most ``most`` places that comes of some starts, and why the search stopped."""
    states = _stepped_once(problem, _begun(problem, starts, budget), budget)
    best = _gone_on(problem, exchanged(problem.exact, states, most, budget), budget)
    others = sorted((state for state in states if len(state.best.draft) <= most), key=_objective_m)[1:]
    for other in others:
        if not budget.affords(_ANOTHER_FLIGHTS):
            break
        pool = [best, _gone_on(problem, other, budget), *states]
        best = _gone_on(problem, exchanged(problem.exact, pool, most, budget), budget)
    return best.best, NO_MORE if budget.affords(_ANOTHER_FLIGHTS) else ENOUGH


def _begun(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> list[State]:
    """As many of the starts as may go on, after a first round; those compared are as far."""
    states: list[State] = []
    for start in starts:
        if not states or budget.affords(_BEGINNING_FLIGHTS):
            on_time = timed(problem, start.draft, start.hovers, budget)
            states.append(State(on_time, start.hovers))
    rounds: list[State] = []
    for state in _hopeful(states):
        if budget.affords(_BEGINNING_FLIGHTS if rounds else ROUND_FLIGHTS):
            rounds.append(rounded(problem, state, budget))
    return _hopeful(rounds or states[:1])


def _hopeful(states: list[State]) -> list[State]:
    """The first of some states, and those that are not much worse than the best."""
    most_m = _HOPELESS * min(map(_objective_m, states))
    return [state for state in states if state is states[0] or state.best.objective_m <= most_m]


def _stepped_once(problem: FitProblem, states: list[State], budget: Budget) -> list[State]:
    """The states in exact steps of the model, after a step each where there is time for that."""
    states = [replace(state, best=problem.exact.evaluate(state.best.draft)) for state in states]
    if not budget.affords(len(states) * JOINT_FLIGHTS + _EXCHANGE_FLIGHTS + _GOING_ON_FLIGHTS):
        return states
    return [_stepped(problem, state, 1, budget) for state in states]


def _gone_on(problem: FitProblem, state: State, budget: Budget) -> State:
    """After as many steps as lead further, and the speeds set anew between them, while that gains."""
    state = _stepped(problem, state, _MANY_STEPS, budget)
    while budget.affords(TIMED_FLIGHTS + JOINT_FLIGHTS):
        before_m = state.best.objective_m
        on_time = timed(problem.exact, state.best.draft, state.hovers, budget)
        anew = replace(state, best=on_time, damping=FIRST_DAMPING)
        state = min(state, _stepped(problem, anew, _MANY_STEPS, budget), key=_objective_m)
        if state.best.objective_m > (1 - WORTH_GOING_ON) * before_m:
            break
    return state


def _stepped(problem: FitProblem, state: State, most: int, budget: Budget) -> State:
    """After steps of all speeds and places together, while they gain and there is time."""
    for _ in range(most):
        before_m = state.best.objective_m
        if not budget.affords(JOINT_FLIGHTS):
            break
        state = stepped_jointly(problem, state, budget)
        if state.best.objective_m >= (1 - WORTH_GOING_ON) * before_m:
            break
    return state


def _objective_m(state: State) -> float:
    return state.best.objective_m

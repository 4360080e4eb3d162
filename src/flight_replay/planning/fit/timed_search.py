"""From first drafts to the best where the recorded speed is to be kept.

Which waypoints a draft begins with decides where a search ends, and little that can be seen before tells
which are good. So there are several starts, each set on its way by steps of all speeds and places together.
The best exchange stretches, and what comes of that goes on as far as steps lead. So do the others, one by
one, while there is time, each exchanging with the best; and in the end legs are changed one by one.

What is found in steps of the model that are long enough to be cheap is judged in exact ones.
"""

from __future__ import annotations

from dataclasses import replace

from flight_replay.planning.fit.exchange import exchanged
from flight_replay.planning.fit.joint_steps import JOINT_FLIGHTS, stepped_jointly
from flight_replay.planning.fit.legs.leg_moves import LATER_SHARE, USUAL_SHARE
from flight_replay.planning.fit.objective import Evaluation, objective_lower_bound_m
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.rounds import (
    ENOUGH,
    FIRST_DAMPING,
    NO_MORE,
    ROUND_FLIGHTS,
    SWEEP_FLIGHTS,
    TIMED_FLIGHTS,
    WORTH_GOING_ON,
    State,
    begun,
    better,
    swept,
    timed,
)

_MANY_STEPS = 100
_MOST_EXCHANGING = 3
_EXCHANGE_FLIGHTS = 40
_ANOTHER_FLIGHTS = 3 * JOINT_FLIGHTS
"""What it takes at least to go on with another start."""
_HOPELESS = 1.5
"""A start so many times worse than the best before its first round, or after it, goes no further."""


def timed_search(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> tuple[Evaluation, str]:
    """The best draft that comes of some starts, and why the search stopped, in words."""
    most = max(len(start.draft) for start in starts)
    states = _stepped_once(problem, _begun(problem, starts, budget), budget)
    state = exchanged(problem.exact, states[:_MOST_EXCHANGING], most, budget)
    state = _gone_on(problem, state, budget)
    for other in states[1:]:
        if budget.affords(_ANOTHER_FLIGHTS):
            both = [state, _gone_on(problem, other, budget)]
            state = _gone_on(problem, exchanged(problem.exact, both, most, budget), budget)
    share = USUAL_SHARE
    while budget.affords(SWEEP_FLIGHTS):
        before_m = state.best.objective_m
        state = _retimed(problem, _turn(problem, state, share, budget), budget)
        if state.best.objective_m > (1 - WORTH_GOING_ON) * before_m:
            return state.best, NO_MORE
        share = LATER_SHARE
    return state.best, ENOUGH


def _stepped_once(problem: FitProblem, states: list[State], budget: Budget) -> list[State]:
    """The states after a step each, in exact steps of the model, the best first.

    Where there is no time for that, they exchange stretches first, and only what comes of that is left.
    """
    if not budget.affords(len(states) * JOINT_FLIGHTS + _EXCHANGE_FLIGHTS + 2 * SWEEP_FLIGHTS):
        most = max(len(state.best.draft) for state in states)
        return [_exactly(problem, exchanged(problem, states, most, budget))]
    states = [_stepped(problem, _exactly(problem, state), 1, budget) for state in states]
    return sorted(states, key=_objective_m)


def _gone_on(problem: FitProblem, state: State, budget: Budget) -> State:
    """After as many steps as lead further, with the speeds set anew between them."""
    return _retimed(problem, _stepped(problem, state, _MANY_STEPS, budget), budget)


def _objective_m(state: State) -> float:
    return state.best.objective_m


def _begun(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> list[State]:
    """As many of the starts as may go on, after a first round."""
    states = [begun(problem, starts[0], budget)]
    for start in starts[1:]:
        best_m = min(map(_objective_m, states))
        least_m = objective_lower_bound_m(start.draft, problem.recording, timed=True)
        if least_m < best_m and budget.affords(ROUND_FLIGHTS + _EXCHANGE_FLIGHTS + SWEEP_FLIGHTS):
            states.append(begun(problem, start, budget, _HOPELESS * best_m))
    most_m = _HOPELESS * min(map(_objective_m, states))
    return [state for state in states if state.best.objective_m <= most_m]


def _exactly(problem: FitProblem, state: State) -> State:
    return replace(state, best=problem.exact.evaluate(state.best.draft))


def _retimed(problem: FitProblem, state: State, budget: Budget) -> State:
    """After the speeds were set anew and steps went on from there, again and again while that gains."""
    while budget.affords(TIMED_FLIGHTS + JOINT_FLIGHTS + SWEEP_FLIGHTS):
        before_m = state.best.objective_m
        on_time = timed(problem.exact, state.best.draft, state.hovers, budget)
        anew = replace(state, best=on_time, damping=FIRST_DAMPING)
        state = min(state, _stepped(problem, anew, _MANY_STEPS, budget), key=_objective_m)
        if state.best.objective_m > (1 - WORTH_GOING_ON) * before_m:
            break
    return state


def _turn(problem: FitProblem, state: State, share: float, budget: Budget) -> State:
    """After legs were changed one by one, and all speeds and places moved together.

    Args:
        problem: what to fit.
        state: a draft as it is flown in exact steps, by which the outcome is judged, too; the legs are
            changed by longer steps, set by them.
        share: legs that cost less than this share of the mean are left as they are.
        budget: is told how much was flown.
    """
    near = problem.calibrated(state.best.draft)
    found = swept(near, replace(state, best=near.evaluate(state.best.draft)), budget, share).best.draft
    on_time = timed(problem.exact, found, state.hovers, budget)
    state = replace(state, best=better(state.best, problem.exact.evaluate(found), on_time))
    return _stepped(problem, state, _MANY_STEPS, budget)


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

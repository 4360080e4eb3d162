"""From first drafts to the best: set the speeds, move the places, change the legs, and again while it gains.

Every start has its first round; the best goes on, and others while there is time. What is found in steps of
the model that are long enough to be cheap is judged in exact ones, where the recorded speed is to be kept.
"""

from __future__ import annotations

from dataclasses import replace

from flight_replay.planning.fit.joint_steps import (
    FIRST_DAMPING,
    JOINT_FLIGHTS,
    JointState,
    stepped_jointly,
)
from flight_replay.planning.fit.legs.leg_moves import LATER_SHARE, USUAL_SHARE
from flight_replay.planning.fit.objective import Evaluation, objective_lower_bound_m
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.reference import Hover
from flight_replay.planning.fit.rounds import (
    ENOUGH,
    ROUND_FLIGHTS,
    SWEEP_FLIGHTS,
    State,
    better,
    polished,
    refined,
    rounded,
    swept,
    timed,
)

_WORTH_GOING_ON = 0.01
_NO_MORE = f"the last steps gained less than {100 * _WORTH_GOING_ON:.0f} %"
_STEPS = 6
_SEARCH_FLIGHTS = 2 * SWEEP_FLIGHTS
_HOPELESS = 1.5
"""A start so many times worse than the best does not get a round."""


def search(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> tuple[Evaluation, str]:
    """The best draft that comes of some starts, and why the search stopped, in words.

    The start that is best after a round goes on to its end. It may be a dead end, as straight legs often are:
    with enough of the budget left the next best goes on, too.
    """
    begun = [_begun(problem, starts[0], budget)]
    for start in starts[1:]:
        best_m = min(state.best.objective_m for state in begun)
        least_m = objective_lower_bound_m(start.draft, problem.recording, timed=problem.timed)
        if least_m < best_m and budget.affords(ROUND_FLIGHTS):
            begun.append(_begun(problem, start, budget, best_m))
    begun.sort(key=lambda state: state.best.objective_m)
    search_on = _timed_search if problem.timed else _untimed_search
    best, stopped = search_on(problem, begun[0], budget)
    for state in begun[1:]:
        if state.best.objective_m < _HOPELESS * best.objective_m and budget.affords(_SEARCH_FLIGHTS):
            found, why = search_on(problem, state, budget)
            best, stopped = (found, why) if found.objective_m < best.objective_m else (best, stopped)
    budget.finish()
    return best, stopped


def _begun(problem: FitProblem, start: FirstDraft, budget: Budget, rival_m: float | None = None) -> State:
    """A start with its speeds set, and after a first round unless it is much worse than a rival."""
    first = timed(problem, start.draft, start.hovers, budget)
    state = State(first, start.hovers)
    if rival_m is not None and first.objective_m > _HOPELESS * rival_m:
        return state
    return rounded(problem, state, budget) if budget.affords(ROUND_FLIGHTS) else state


def _untimed_search(problem: FitProblem, state: State, budget: Budget) -> tuple[Evaluation, str]:
    """The best of places moved, and of legs changed one by one between that; and why it ends."""
    while budget.affords(SWEEP_FLIGHTS):
        before_m = state.best.objective_m
        state = refined(problem, polished(problem, state, budget), budget, _STEPS)
        state = polished(problem, swept(problem, state, budget, USUAL_SHARE), budget)
        if state.best.objective_m > (1 - _WORTH_GOING_ON) * before_m:
            return state.best, _NO_MORE
    return state.best, ENOUGH


def _timed_search(problem: FitProblem, state: State, budget: Budget) -> tuple[Evaluation, str]:
    """The best of places moved, legs changed one by one, and all speeds and places moved together.

    Each turn is in steps that are set by the exact ones anew, by which its outcome is judged.
    """
    best, share, damping = problem.exact.evaluate(state.best.draft), USUAL_SHARE, FIRST_DAMPING
    while budget.affords(SWEEP_FLIGHTS):
        near, before_m = problem.calibrated(best.draft), best.objective_m
        state = replace(state, best=near.evaluate(best.draft))
        state = swept(near, refined(near, state, budget, _STEPS), budget, share)
        found = state.best.draft
        on_time = timed(problem.exact, found, state.hovers, budget)
        best, share = better(best, problem.exact.evaluate(found), on_time), LATER_SHARE
        best, damping = _joint_steps(problem, JointState(best, damping), state.hovers, budget)
        if best.objective_m > (1 - _WORTH_GOING_ON) * before_m:
            return best, _NO_MORE
    return best, ENOUGH


def _joint_steps(
    problem: FitProblem, state: JointState, hovers: dict[int, Hover], budget: Budget
) -> tuple[Evaluation, float]:
    """The best after steps of all places and speeds together, as long as they gain, and the damping."""
    gains = True
    while gains:
        before_m = state.best.objective_m
        state = stepped_jointly(problem, state, hovers, budget)
        gains = state.best.objective_m < (1 - _WORTH_GOING_ON) * before_m and budget.affords(JOINT_FLIGHTS)
    return state.best, state.damping

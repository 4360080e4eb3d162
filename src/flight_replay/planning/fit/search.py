"""From first drafts to the best: set the speeds, move the places, change the legs, and again while it gains.

What is found in steps of the model that are long enough to be cheap is judged in exact ones, where the
recorded speed is to be kept.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf

from flight_replay.planning.fit.joint_steps import JOINT_FLIGHTS, stepped_jointly
from flight_replay.planning.fit.legs.leg_moves import LATER_SHARE, USUAL_SHARE
from flight_replay.planning.fit.objective import Evaluation, objective_lower_bound_m
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
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
_STEPS = 5
_SEARCH_FLIGHTS = 2 * SWEEP_FLIGHTS
_TURN_FLIGHTS = 80
"""A turn of a timed search with few joint steps costs about as many."""
_FEW_JOINT_STEPS, _MANY_JOINT_STEPS = 3, 100
_HOPELESS = 1.5
"""A start so many times worse than the best does not get a round."""


def search(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> tuple[Evaluation, str]:
    """The best draft that comes of some starts, and why the search stopped, in words."""
    begun = [_begun(problem, starts[0], budget)]
    for start in starts[1:]:
        best_m = min(state.best.objective_m for state in begun)
        least_m = objective_lower_bound_m(start.draft, problem.recording, timed=problem.timed)
        if least_m < best_m and budget.affords(ROUND_FLIGHTS):
            most_m = _hopeless(problem, len(begun), budget) * best_m
            begun.append(_begun(problem, start, budget, most_m))
    begun.sort(key=lambda state: state.best.objective_m)
    found = (_timed_search if problem.timed else _untimed_search)(problem, begun, budget)
    budget.finish()
    return found


def _begun(problem: FitProblem, start: FirstDraft, budget: Budget, most_m: float = inf) -> State:
    """A start with its speeds set, and after a first round unless it costs more than ``most_m`` before."""
    first = timed(problem, start.draft, start.hovers, budget)
    state = State(first, start.hovers)
    if first.objective_m > most_m:
        return state
    return rounded(problem, state, budget) if budget.affords(ROUND_FLIGHTS) else state


def _hopeless(problem: FitProblem, begun: int, budget: Budget) -> float:
    """How many times worse than the best a start may be before its first round, after so many others.

    Where the recorded speed is kept, the second has a turn anyway if there is time for it.
    """
    if not problem.timed:
        return _HOPELESS
    return inf if begun == 1 and _affords_turns(budget) else 1.0


def _affords_turns(budget: Budget) -> bool:
    """Whether two states may have a turn each."""
    return budget.affords(2 * _TURN_FLIGHTS)


def _untimed_search(problem: FitProblem, begun: list[State], budget: Budget) -> tuple[Evaluation, str]:
    """The best that comes of the first of some states, and of the next while there is time, and why it ends.

    The first may be a dead end, as straight legs often are.
    """
    best, stopped = _searched(problem, begun[0], budget)
    for state in begun[1:]:
        if state.best.objective_m < _HOPELESS * best.objective_m and budget.affords(_SEARCH_FLIGHTS):
            found, why = _searched(problem, state, budget)
            best, stopped = (found, why) if found.objective_m < best.objective_m else (best, stopped)
    return best, stopped


def _searched(problem: FitProblem, state: State, budget: Budget) -> tuple[Evaluation, str]:
    """The best of places moved, and of legs changed one by one between that; and why it ends."""
    while budget.affords(SWEEP_FLIGHTS):
        before_m = state.best.objective_m
        state = refined(problem, polished(problem, state, budget), budget, _STEPS)
        state = polished(problem, swept(problem, state, budget, USUAL_SHARE), budget)
        if state.best.objective_m > (1 - _WORTH_GOING_ON) * before_m:
            return state.best, _NO_MORE
    return state.best, ENOUGH


def _timed_search(problem: FitProblem, begun: list[State], budget: Budget) -> tuple[Evaluation, str]:
    """The best that some states come to in turns, and why it ends.

    The first two each have a turn if there is time: which is better before says little of what comes of them,
    and another one's first turn gains more than a second. The best then has further turns.
    """
    several = len(begun) > 1 and _affords_turns(budget)
    exact = [replace(state, best=problem.exact.evaluate(state.best.draft)) for state in begun[: 1 + several]]
    most = _FEW_JOINT_STEPS if several else _MANY_JOINT_STEPS
    turned = [
        _turn(problem, state, USUAL_SHARE, most, budget) for state in exact if budget.affords(SWEEP_FLIGHTS)
    ]
    state = min([exact[0], *turned], key=lambda each: each.best.objective_m)
    while budget.affords(SWEEP_FLIGHTS):
        before_m = state.best.objective_m
        state = _turn(problem, state, LATER_SHARE, _MANY_JOINT_STEPS, budget)
        if state.best.objective_m > (1 - _WORTH_GOING_ON) * before_m:
            return state.best, _NO_MORE
    return state.best, ENOUGH


def _turn(problem: FitProblem, state: State, share: float, most: int, budget: Budget) -> State:
    """After places were moved, legs changed one by one, and all speeds and places moved together.

    Args:
        problem: what to fit.
        state: a draft as it is flown in exact steps, by which the outcome is judged, too; the turn's own
            steps are set by them.
        share: legs that cost less than this share of the mean are left as they are.
        most: joint steps at most; fewer where they do not gain.
        budget: is told how much was flown.
    """
    near = problem.calibrated(state.best.draft)
    moved = refined(near, replace(state, best=near.evaluate(state.best.draft)), budget, _STEPS)
    found = swept(near, moved, budget, share).best.draft
    on_time = timed(problem.exact, found, state.hovers, budget)
    state = replace(state, best=better(state.best, problem.exact.evaluate(found), on_time))
    for _ in range(most):
        before_m = state.best.objective_m
        state = stepped_jointly(problem, state, budget)
        if state.best.objective_m >= (1 - _WORTH_GOING_ON) * before_m or not budget.affords(JOINT_FLIGHTS):
            break
    return state

"""From first drafts to the best: set the speeds, move the places, change the legs, and again while it gains.

Every start has its first round; the best goes on. What is found in steps of the model that are long
enough to be cheap is judged in exact ones, where the recorded speed is to be kept.
"""

from __future__ import annotations

from flight_replay.planning.fit.objective import Evaluation, objective_lower_bound_m
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.rounds import (
    ENOUGH,
    ROUND_FLIGHTS,
    SWEEP_FLIGHTS,
    State,
    better,
    refined,
    rounded,
    swept,
    timed,
)

_WORTH_GOING_ON = 0.01
_NO_MORE = f"the last steps gained less than {100 * _WORTH_GOING_ON:.0f} %"
_HOPELESS = 1.5
"""A start so many times worse than the best does not get a round."""


def search(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> tuple[Evaluation, str]:
    """The best draft that comes of some starts, and why the search stopped, in words."""
    state = _begun(problem, starts[0], budget)
    for start in starts[1:]:
        least_m = objective_lower_bound_m(start.draft, problem.recording, timed=problem.timed)
        if least_m < state.best.objective_m and budget.affords(ROUND_FLIGHTS):
            rival = _begun(problem, start, budget, state.best.objective_m)
            state = min(state, rival, key=lambda each: each.best.objective_m)
    best, stopped = (_timed_search if problem.timed else _untimed_search)(problem, state, budget)
    budget.finish()
    return best, stopped


def _begun(problem: FitProblem, start: FirstDraft, budget: Budget, rival_m: float | None = None) -> State:
    """A start with its speeds set, and after a first round unless it is much worse than a rival."""
    first = timed(problem, start.draft, start.hovers, budget)
    state = State(first, first, start.hovers)
    if rival_m is not None and first.objective_m > _HOPELESS * rival_m:
        return state
    return rounded(problem, state, budget) if budget.affords(ROUND_FLIGHTS) else state


def _untimed_search(problem: FitProblem, state: State, budget: Budget) -> tuple[Evaluation, str]:
    """The best of rounds and refinements, and of legs changed one by one between them; and why it ends."""
    while True:
        before_m = state.best.objective_m
        best, stopped = refined(problem, state, budget)
        if budget.affords(SWEEP_FLIGHTS):
            best = better(best, swept(problem, best, state.hovers, budget))
        if not budget.affords(ROUND_FLIGHTS):
            return best, stopped
        state = rounded(problem, State(best, best, state.hovers), budget)
        if state.best.objective_m > (1 - _WORTH_GOING_ON) * before_m:
            return state.best, _NO_MORE


def _timed_search(problem: FitProblem, state: State, budget: Budget) -> tuple[Evaluation, str]:
    """The best of small rounds, and of legs changed one by one after them; and why it ends."""
    exact, start = problem.exact, state
    best = exact.evaluate(state.best.draft)
    while budget.affords(SWEEP_FLIGHTS + ROUND_FLIGHTS):
        before_m = best.objective_m
        near = problem.calibrated(start.best.draft)
        moved, _ = refined(near, _evaluated(near, start), budget)
        found = [exact.evaluate(moved.draft)]
        if budget.affords(SWEEP_FLIGHTS):
            found.append(exact.evaluate(swept(near, moved, state.hovers, budget).draft))
        best = better(best, *found)
        if best.objective_m > (1 - _WORTH_GOING_ON) * before_m:
            return best, _NO_MORE
        near = problem.calibrated(best.draft)
        start = rounded(near, _evaluated(near, State(best, best, state.hovers)), budget)
    return better(best, exact.evaluate(start.best.draft)), ENOUGH


def _evaluated(problem: FitProblem, state: State) -> State:
    """The best draft as it is in another problem."""
    best = problem.evaluate(state.best.draft)
    return State(best, best, state.hovers)

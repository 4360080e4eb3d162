"""From first drafts to the best: set the speeds, move the places, and again, while that gains something.

A round moves the places at the speeds there are, and then sets the speeds anew. Every start has
its first round; the best goes on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.objective import Evaluation, objective_lower_bound_m
from flight_replay.planning.fit.place_moves import shaped, stepped
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.reference import Hover
from flight_replay.planning.fit.speed_schedule import LEAST_HOLD_S, schedule, speed_caps_m_s, with_speeds
from flight_replay.planning.fit.speed_search import SpeedSearch

_STEPS = 4
_TIMED_FLIGHTS = 6.5
"""A pass over the speeds costs about as many flights: each leg is flown several times."""
_ROUND_FLIGHTS = _TIMED_FLIGHTS + _STEPS
_LEAST_GAIN, _MORE, _LESS = 0.1, 1.5, 0.5
_WORTH_GOING_ON = 0.01
_HOPELESS = 1.5
"""A start so many times worse than the best does not get a round."""


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """Where a search is: the last round's outcome, and the best so far."""

    last: Evaluation
    best: Evaluation
    hovers: dict[int, Hover]


def search(problem: FitProblem, starts: list[FirstDraft], budget: Budget) -> tuple[Evaluation, str]:
    """The best draft that comes of some starts, and why the search stopped, in words."""
    state = _begun(problem, starts[0], budget)
    for start in starts[1:]:
        least_m = objective_lower_bound_m(start.draft, problem.recording, timed=problem.timed)
        if least_m < state.best.objective_m and budget.affords(_ROUND_FLIGHTS):
            rival = _begun(problem, start, budget, state.best.objective_m)
            state = min(state, rival, key=lambda each: each.best.objective_m)
    while True:
        before_m = state.best.objective_m
        best, stopped = _refined(problem, state, budget)
        state = _State(best, best, state.hovers)
        if not budget.affords(_ROUND_FLIGHTS):
            break
        state = _round(problem, state, budget)
        if state.best.objective_m > (1 - _WORTH_GOING_ON) * before_m:
            stopped = f"the last steps gained less than {100 * _WORTH_GOING_ON:.0f} %"
            break
    budget.finish()
    return state.best, stopped


def _refined(problem: FitProblem, state: _State, budget: Budget) -> tuple[Evaluation, str]:
    """The best of small rounds of one step each, longer or shorter as they succeed; and why they end."""
    best, gain = state.best, 1.0
    while gain >= _LEAST_GAIN:
        if not budget.affords(_TIMED_FLIGHTS):
            return best, "so many flights are enough for a recording of this length"
        trial = _timed(problem, stepped(problem, best, state.hovers, gain), state.hovers, budget)
        if trial.objective_m < best.objective_m:
            best, gain = trial, min(1.0, _MORE * gain)
        else:
            gain *= _LESS
    return best, "no step makes it better"


def _begun(problem: FitProblem, start: FirstDraft, budget: Budget, rival_m: float | None = None) -> _State:
    """A start with its speeds set, and after a first round unless it is much worse than a rival."""
    first = _timed(problem, start.draft, start.hovers, budget)
    state = _State(first, first, start.hovers)
    if rival_m is not None and first.objective_m > _HOPELESS * rival_m:
        return state
    return _round(problem, state, budget) if budget.affords(_ROUND_FLIGHTS) else state


def _round(problem: FitProblem, state: _State, budget: Budget) -> _State:
    moved = shaped(problem, state.last, state.hovers, _STEPS, budget)
    timed = _timed(problem, moved.draft, state.hovers, budget) if problem.timed else moved
    return _State(timed, min(state.best, moved, timed, key=lambda each: each.objective_m), state.hovers)


def _timed(problem: FitProblem, draft: Draft, hovers: dict[int, Hover], budget: Budget) -> Evaluation:
    """A draft evaluated with the speeds and waits that keep it nearest to the recording's times."""
    if not problem.timed or len(draft) < 2:
        budget.spend(1)
        return problem.evaluate(draft)
    recording = problem.recording
    caps = speed_caps_m_s(draft, recording)
    hurried = replace(draft, hold_s=np.minimum(draft.hold_s, LEAST_HOLD_S))
    least_s = np.diff(problem.simulate(with_speeds(hurried, caps)).passed_s, prepend=0.0) - hurried.hold_s
    plan = schedule(draft, hovers, recording, least_s)
    speeds = SpeedSearch(plan, caps, problem.limits, problem.step_s, recording.home_amsl_m)
    found = problem.evaluate(with_speeds(plan.draft, speeds.run()))
    budget.spend(2 + speeds.steps * problem.step_s / max(float(found.flight.time_s[-1]), problem.step_s))
    return found

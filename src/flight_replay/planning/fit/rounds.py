"""The steps of a search: the speeds set anew, the places moved, the legs changed one by one."""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.legs.leg_moves import with_better_legs
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.place_moves import shaped, stepped
from flight_replay.planning.fit.problem import Budget, FitProblem
from flight_replay.planning.fit.reference import Hover
from flight_replay.planning.fit.speed_schedule import schedule, speed_caps_m_s, with_speeds
from flight_replay.planning.fit.speed_search import SpeedSearch

_STEPS = 4
TIMED_FLIGHTS = 6.5
"""A pass over the speeds costs about as many flights: each leg is flown several times."""
ROUND_FLIGHTS = TIMED_FLIGHTS + _STEPS
SWEEP_FLIGHTS = 25
"""A way through the legs costs at least about as many: each is flown with those around it."""
ENOUGH = "so many flights are enough for a recording of this length"
_LEAST_GAIN, _MORE, _LESS = 0.1, 1.5, 0.5


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Where a search is: the last round's outcome, and the best so far."""

    last: Evaluation
    best: Evaluation
    hovers: dict[int, Hover]


def better(*found: Evaluation) -> Evaluation:
    """The one with the smallest objective."""
    return min(found, key=lambda each: each.objective_m)


def rounded(problem: FitProblem, state: State, budget: Budget) -> State:
    """After the places were moved at the speeds there are, and the speeds set anew."""
    moved = shaped(problem, state.last, state.hovers, _STEPS, budget)
    again = timed(problem, moved.draft, state.hovers, budget) if problem.timed else moved
    return State(again, better(state.best, moved, again), state.hovers)


def refined(problem: FitProblem, state: State, budget: Budget) -> tuple[Evaluation, str]:
    """The best of small rounds of one step each, longer or shorter as they succeed; and why they end."""
    best, gain = state.best, 1.0
    while gain >= _LEAST_GAIN:
        if not budget.affords(TIMED_FLIGHTS):
            return best, ENOUGH
        trial = timed(problem, stepped(problem, best, state.hovers, gain), state.hovers, budget)
        if trial.objective_m < best.objective_m:
            best, gain = trial, min(1.0, _MORE * gain)
        else:
            gain *= _LESS
    return best, "no step makes it better"


def swept(problem: FitProblem, start: Evaluation, hovers: dict[int, Hover], budget: Budget) -> Evaluation:
    """With legs straight or curved, stops and speeds as the model flies them better, one by one."""
    budget.spend(1)
    return problem.evaluate(with_better_legs(problem, start, hovers, budget))


def timed(problem: FitProblem, draft: Draft, hovers: dict[int, Hover], budget: Budget) -> Evaluation:
    """A draft evaluated with the speeds and waits that keep it nearest to the recording's times."""
    if not problem.timed or len(draft) < 2:
        budget.spend(1)
        return problem.evaluate(draft)
    recording = problem.recording
    caps = speed_caps_m_s(draft, recording)
    plan = schedule(draft, hovers, recording, problem.least_leg_s(draft, caps))
    speeds = SpeedSearch(plan, caps, problem.limits, problem.step_s, recording.home_amsl_m)
    found = problem.evaluate(with_speeds(plan.draft, speeds.run()))
    budget.spend(2 + speeds.steps * problem.step_s / max(float(found.flight.time_s[-1]), problem.step_s))
    return found

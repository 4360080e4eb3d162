"""The steps of a search: the places moved, the speeds set anew, the legs changed one by one."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft, without_hooks
from flight_replay.planning.fit.legs.leg_moves import with_better_legs
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.offsets import match_to_plan
from flight_replay.planning.fit.place_moves import moved_once, shaped
from flight_replay.planning.fit.problem import Budget, FitProblem
from flight_replay.planning.fit.reference import Hover
from flight_replay.planning.fit.speed_schedule import Schedule, schedule, speed_caps_m_s
from flight_replay.planning.fit.speed_search import SpeedSearch

_PATH_STEPS = 4
TIMED_FLIGHTS = 4.5
"""A pass over the speeds costs about as many flights: many a leg is flown several times."""
MOVING_FLIGHTS = _PATH_STEPS + 1
ROUND_FLIGHTS = TIMED_FLIGHTS + _PATH_STEPS
SWEEP_FLIGHTS = 25
"""A way through the legs costs at least about as many: each is flown with those around it."""
ENOUGH = "so many flights are enough for a recording of this length"
WORTH_GOING_ON = 0.01
HOPELESS = 1.5
"""A start so many times worse than the best goes no further."""
NO_MORE = f"the last steps gained less than {100 * WORTH_GOING_ON:.0f} %"
COMES_DOWN = (
    "flown like this the vehicle would come down to less than half of its lowest planned height; "
    "ask for a lower --speed or another --altitude"
)

FIRST_DAMPING = 0.01
_LEAST_GAIN, _MORE, _LESS = 0.1, 1.5, 0.5


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Where a search is: the best so far, and the hovers by the place at which they are waited for.

    The next step of all places and speeds together is damped by ``damping``; its changes are to one side or
    to both, of ``change_size`` as a share of the usual.
    """

    best: Evaluation
    hovers: dict[int, Hover]
    damping: float = FIRST_DAMPING
    change_size: float = 1.0
    both_sides: bool = False

    @property
    def objective_m(self) -> float:
        """That of the best so far."""
        return self.best.objective_m


def better(*found: Evaluation) -> Evaluation:
    """The one with the smallest objective."""
    return min(found, key=lambda each: each.objective_m)


def hopeful(states: list[State]) -> list[State]:
    """The first of the states in which the vehicle stays up, and those not much worse than the best.

    Raises:
        MissionError: there are none.
    """
    up = [state for state in states if state.best.flight.stays_up]
    if not up:
        raise MissionError(COMES_DOWN)
    most_m = HOPELESS * min(state.objective_m for state in up)
    return [state for state in up if state is up[0] or state.objective_m <= most_m]


def rounded_hopeful(
    problem: FitProblem, states: list[State], budget: Budget, first_flights: float, next_flights: float
) -> list[State]:
    """The hopeful of some states, as many as may go on after a first round; those compared are as far.

    Args:
        problem: what to fit.
        states: as they begin.
        budget: is told how much was flown.
        first_flights: what there must be left for the round of the first of them.
        next_flights: for another one, and what comes after that.

    Raises:
        MissionError: in none of them the vehicle stays up.
    """
    rounds: list[State] = []
    for state in hopeful(states):
        if budget.affords(next_flights if rounds else first_flights):
            rounds.append(rounded(problem, state, budget))
    return hopeful(rounds) if rounds else hopeful(states)[:1]


def rounded(problem: FitProblem, state: State, budget: Budget) -> State:
    """After the places were moved at the speeds there are, and the speeds set anew if they are to be kept."""
    fly = partial(flown, problem, budget=budget)
    nearer = shaped(problem, state.best, state.hovers, _PATH_STEPS, fly)
    again = flown_on_schedule(problem, nearer.draft, state.hovers, budget) if problem.timed else nearer
    return replace(state, best=better(state.best, nearer, again))


def polished(problem: FitProblem, state: State, budget: Budget) -> State:
    """After steps of all places by what lies beside the paths, longer or shorter as they succeed."""
    best, gain = state.best, 1.0
    while gain >= _LEAST_GAIN and budget.affords(1):
        trial = flown(problem, moved_once(problem, best, state.hovers, gain), budget)
        if trial.objective_m < best.objective_m:
            best, gain = trial, min(1.0, _MORE * gain)
        else:
            gain *= _LESS
    return replace(state, best=best)


def swept(problem: FitProblem, state: State, budget: Budget) -> State:
    """With legs straight or curved, and stops, as the model flies them better, one by one."""
    changed = flown(problem, with_better_legs(problem, state.best, state.hovers, budget), budget)
    return replace(state, best=better(state.best, changed))


def flown(problem: FitProblem, draft: Draft, budget: Budget) -> Evaluation:
    """A draft evaluated at the speeds it has."""
    budget.spend(1)
    return problem.evaluate(draft)


def flown_on_schedule(
    problem: FitProblem, draft: Draft, hovers: dict[int, Hover], budget: Budget
) -> Evaluation:
    """A draft evaluated with the speeds and waits that keep it nearest to the recording's times."""
    if len(draft) < 2:
        return flown(problem, draft, budget)
    draft, recording = without_hooks(problem.held(draft)), problem.recording
    planned, _ = match_to_plan(draft, recording)
    caps = speed_caps_m_s(planned, len(draft), recording)
    plan = schedule(draft, hovers, recording, planned, problem.least_leg_s(draft, caps))
    speeds = SpeedSearch(plan, caps, problem.limits, problem.step_s, recording.takeoff)
    found = problem.compared(speeds.run())
    budget.spend(2 + problem.flights_of(speeds.steps, found.flight))
    return found


def flown_leaving(problem: FitProblem, draft: Draft, leave_s: Floats) -> tuple[Evaluation, float]:
    """A draft as it is flown, and the flights that took; with its speeds set where they are to be kept.

    Args:
        problem: what to fit, in the steps in which the draft is to be judged.
        draft: at least two places.
        leave_s: when each of them is to be left then (n,).
    """
    if not problem.timed:
        return problem.evaluate(draft), 1.0
    planned, _ = match_to_plan(draft, problem.recording)
    caps_m_s = speed_caps_m_s(planned, len(draft), problem.recording)
    found, steps = flown_on_time(problem, Schedule(draft, leave_s), caps_m_s)
    return found, 1 + problem.flights_of(steps, found.flight)


def changed_flown(problem: FitProblem, changes: Iterable[tuple[Draft, Floats]]) -> list[Evaluation]:
    """Changed drafts as they are flown in exact steps, without those that do not end or come down.

    Where the recorded speed is to be kept, with their speeds set anew and as they are: speeds that were found
    together are rarely found again one by one.

    Args:
        problem: what to fit.
        changes: drafts of at least two places, and when each place is to be left then (n,).
    """
    found = []
    for draft, leave_s in changes:
        with suppress(MissionError):
            found.append(flown_leaving(problem.exact, draft, leave_s)[0])
        if problem.timed:
            with suppress(MissionError):
                found.append(problem.exact.evaluate(draft))
    return [each for each in found if each.flight.stays_up]


def flown_on_time(problem: FitProblem, plan: Schedule, caps_m_s: Floats) -> tuple[Evaluation, int]:
    """A draft with its speeds set to leave each place when it is to be left, and the model's steps that took.

    Args:
        problem: what to fit.
        plan: the draft, at least two places, and when they are to be left.
        caps_m_s: the highest speeds (n,), where the draft has none that is higher.
    """
    plan = replace(plan, draft=without_hooks(problem.held(plan.draft)))
    caps_m_s = np.fmax(caps_m_s, plan.draft.speed_m_s)
    search = SpeedSearch(plan, caps_m_s, problem.limits, problem.step_s, problem.recording.takeoff)
    return problem.compared(search.run()), search.steps

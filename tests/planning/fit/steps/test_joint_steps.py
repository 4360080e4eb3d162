"""Steps of all speeds and places together gain, stay near the recording, and stop where they cannot."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.first_drafts.knot_selection import select_waypoints
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.legs.flight_derivatives import FlightDerivatives, flight_derivatives
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import local_track
from flight_replay.planning.fit.rounds import State, flown_on_schedule, flown_on_time
from flight_replay.planning.fit.speed_schedule import Schedule
from flight_replay.planning.fit.steps import joint_steps
from flight_replay.planning.fit.steps.joint_steps import stepped, stepped_jointly
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import budget, draft_of, recording_of, wander


def problem_and_start(*, is_timed: bool = True) -> tuple[FitProblem, State]:
    problem = problem_for(local_track(wander(4), 20.0), 20, Limits(), timed=is_timed)
    draft = select_waypoints(problem, 20).draft
    start = flown_on_schedule(problem.exact, draft, {}, budget()) if is_timed else problem.evaluate(draft)
    return problem, State(start, {})


def test_a_joint_step_brings_the_flight_nearer_to_the_recording() -> None:
    """In place and time: a draft with its speeds set gains a twentieth of the objective."""
    problem, start = problem_and_start()
    spent = budget()
    found = stepped_jointly(problem, start, spent)
    assert found.best.objective_m < 0.95 * start.best.objective_m
    assert found.damping <= start.damping
    assert spent.spent > 3
    places = found.best.draft.places_m[:, :2]
    feet = problem.recording.nearest_m(places)
    assert np.linalg.norm(places - feet, axis=1).max() < 4.01


def test_at_the_vehicles_own_speed_a_step_moves_the_places_alone() -> None:
    """It gains, and no speed is asked for."""
    problem, start = problem_and_start(is_timed=False)
    spent = budget()
    found = stepped_jointly(problem, start, spent)
    assert found.objective_m < 0.9 * start.objective_m
    assert np.isnan(found.best.draft.speed_m_s).all()
    assert (found.best.draft.places_m != start.best.draft.places_m).any(axis=1).sum() > 10
    assert 3 < spent.spent < 20


@pytest.mark.parametrize("hold_s", [5.0, 11.0])
def test_waits_become_longer_or_shorter(hold_s: float) -> None:
    """By three seconds, as the recorded vehicle waited for eight; they stay whole seconds."""
    draft = draft_of([(0, 0), (30, 0), (30, 30), (60, 30)], [False] * 4, [6, 0, 8, 0])
    draft = replace(draft, speed_m_s=np.array([np.nan, 3.0, 4.0, 5.0]))
    problem, start = problem_and_start()
    problem = replace(problem, recording=recording_of(problem.exact.simulate(draft)))
    wrong = replace(draft, hold_s=np.array([6.0, 0.0, hold_s, 0.0]))
    state = replace(start, best=problem.exact.evaluate(wrong))
    found = stepped(problem, state, budget()).best
    assert found.draft.hold_s.tolist() == [6.0, 0.0, 8.0, 0.0]
    assert found.late_m.mean() < 0.1 * state.best.late_m.mean()


def test_steps_that_fail_are_damped_more(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was best stays where no step gains, and the next one is shorter."""
    problem, start = problem_and_start()
    monkeypatch.setattr(joint_steps, "flown_on_time", lambda *_: (start.best, 0))
    found = stepped_jointly(problem, start, budget())
    assert found.best is start.best
    assert found.damping > start.damping


def test_a_step_that_fails_is_taken_where_it_is_better(monkeypatch: pytest.MonkeyPatch) -> None:
    """A trial that is far behind in the end alone: all but the places there move."""
    problem, start = problem_and_start()
    asked: list[Draft] = []

    def late_at_first(problem: FitProblem, plan: Schedule, caps_m_s: Floats) -> tuple[Evaluation, int]:
        trial, steps = flown_on_time(problem, plan, caps_m_s)
        asked.append(plan.draft)
        if len(asked) == 1:
            behind_m = np.where(np.arange(len(trial.late_off_m)) < 70, 0.0, 500.0)
            trial = replace(trial, late_off_m=trial.late_off_m + behind_m[:, None])
        return trial, steps

    monkeypatch.setattr(joint_steps, "flown_on_time", late_at_first)
    found = stepped_jointly(problem, start, budget())
    moved = (asked[1].places_m != start.best.draft.places_m).any(axis=1)
    assert moved[1:10].any()
    assert not moved[-3:].any()
    assert found.objective_m < start.objective_m


def test_where_changes_to_one_side_lead_nowhere_those_to_the_other_count_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And from there on; where both lead nowhere, smaller ones are made."""
    problem, start = problem_and_start()
    sizes: list[float] = []

    def watched(*args: Any) -> FlightDerivatives:
        sizes.append(args[-1])
        return flight_derivatives(*args)

    monkeypatch.setattr(joint_steps, "flight_derivatives", watched)
    after = stepped_jointly(problem, start, budget())
    monkeypatch.setattr(joint_steps, "flown_on_time", lambda *_: (after.best, 0))
    again = stepped_jointly(problem, after, budget())
    stepped_jointly(problem, again, budget())
    assert sizes == [1.0, 1.0, -1.0, 0.5, -0.5]


def test_steps_that_gain_little_are_followed_by_such_to_both_sides(monkeypatch: pytest.MonkeyPatch) -> None:
    """Near the best most changes have a kink."""
    problem, start = problem_and_start()
    assert not stepped_jointly(problem, start, budget()).both_sides
    monkeypatch.setattr(joint_steps, "_SMOOTH_GAIN", 1.0)
    assert stepped_jointly(problem, start, budget()).both_sides


def test_what_would_take_too_much_memory_is_left_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """The derivatives are as many as errors times changes: too many for long flights through many places."""
    problem, start = problem_and_start()
    monkeypatch.setattr(joint_steps, "_MOST_DERIVATIVES", 50_000)
    assert stepped_jointly(problem, start, budget()) is start

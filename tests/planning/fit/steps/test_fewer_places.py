"""Places that make the vehicle late are left out, and no others."""

from dataclasses import replace

import numpy as np

from flight_replay.logs.track import Track
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import Hover, local_track
from flight_replay.planning.fit.rounds import State, flown_leaving
from flight_replay.planning.fit.steps.fewer_places import _changes, with_fewer_places
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, budget, circle, draft_of, track_through

SPEED_M_S, RADIUS_M = 2.0, 30.0
WAY = [(0.0, 0.0), (30.0, 0.0), (60.0, 0.0), (90.0, 0.0), (120.0, 0.0)]
HALF_CIRCLE = [(RADIUS_M * np.sin(turn), RADIUS_M * (1 - np.cos(turn))) for turn in np.linspace(0, np.pi, 9)]
HOVER = Hover(0, 1, 5.0)
"""Some hover: which is not looked at."""


def problem_of(track: Track, limits: Limits | None = None) -> FitProblem:
    return problem_for(local_track(track, 20.0), 10, limits or Limits(), timed=True)


def state_of(problem: FitProblem, way: list[tuple[float, float]], hold_s: list[float]) -> State:
    """The way flown on curves with waits, each place left as recorded where that can be."""
    leave_s = np.linspace(0.0, problem.recording.time_s[-1], len(way))
    draft = draft_of(way, [False, *[True] * (len(way) - 1)], hold_s)
    return State(flown_leaving(problem.exact, draft, leave_s)[0], {3: HOVER, 4: HOVER})


def test_a_stop_that_was_none_is_left_out() -> None:
    """It makes all that follows late; what is waited for elsewhere is, by its new place."""
    problem, spent = problem_of(along(WAY, SPEED_M_S)), budget()
    late = state_of(problem, WAY, [6, 0, 0, 1, 0])
    found = with_fewer_places(problem, late, spent)
    assert found.objective_m < 0.6 * late.objective_m
    assert not found.best.draft.hold_s[1:].any()
    assert found.hovers == {3: HOVER}
    assert spent.spent > 1


def test_a_stop_in_a_bend_is_flown_through() -> None:
    """The place stays where it was; without it the bend would be cut."""
    problem = problem_of(circle(RADIUS_M, SPEED_M_S, 0.5))
    late = state_of(problem, HALF_CIRCLE, [6, 0, 0, 1, 0, 0, 0, 0, 0])
    found = with_fewer_places(problem, late, budget())
    assert found.objective_m < late.objective_m
    assert len(found.best.draft) == len(HALF_CIRCLE)
    assert not found.best.draft.hold_s[1:].any()
    assert found.hovers == {4: HOVER}


def test_stops_are_left_straight_where_they_have_to_be() -> None:
    """At high limits a curve from a stop may leap, and the place before the one left out may be a stop."""
    problem = problem_of(along(WAY, SPEED_M_S), Limits(wp_accel_m_s2=6.0))
    late = state_of(problem, WAY, [6, 0, 15, 15, 0])
    drafts = [draft for draft, _, _ in _changes(late, problem)]
    assert len(drafts) > 2
    assert not any((draft.spline[1:] & (draft.hold_s[:-1] > 0)).any() for draft in drafts)


def test_with_speeds_set_anew_what_comes_before_is_left_sooner() -> None:
    """A hover, where the vehicle is late on the leg that follows the stop after it, whatever its speed."""
    time_s = np.arange(0.0, 60.0, 0.25)
    north_m = np.maximum(time_s - 10.0, 0.0) * 10.2
    problem = problem_of(track_through(np.column_stack([north_m, 0.0 * north_m]), time_s))
    draft = draft_of([(0.0, 0.0), (0.1, 0.0), (60.0, 0.0), (510.0, 0.0)], [False] * 4, [6, 7, 1, 0])
    leave_s = np.array([0.0, 9.5, 16.0, 60.0])
    late = State(flown_leaving(problem.exact, draft, leave_s)[0], {1: Hover(0, 40, 10.0)})
    as_before = with_fewer_places(problem, late, budget())
    anew = with_fewer_places(problem, late, budget(), anew=4)
    assert as_before.best.draft.hold_s[1] == 7
    assert anew.best.draft.hold_s[1] == 1
    assert anew.objective_m < as_before.objective_m < late.objective_m


def test_a_draft_that_keeps_up_stays_as_it_is() -> None:
    """Nothing is flown for it."""
    problem, spent = problem_of(along(WAY, SPEED_M_S)), budget()
    good = state_of(problem, WAY, [6, 0, 0, 0, 0])
    good = replace(good, best=replace(good.best, flown_s=problem.recording.time_s.copy()))
    assert with_fewer_places(problem, good, spent) is good
    assert spent.spent == 0


def test_places_are_tried_up_to_a_quarter_more_flights_than_are_enough() -> None:
    """A recording of hours is flown a few times only."""
    problem, spent = problem_of(along(WAY, SPEED_M_S)), budget(8)
    late = state_of(problem, WAY, [6, 0, 0, 1, 0])
    spent.spend(9.1)
    assert with_fewer_places(problem, late, spent) is late
    assert spent.spent == 9.1

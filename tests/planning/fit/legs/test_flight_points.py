"""Points of a flight: which are passed when, and what of their moves counts."""

from dataclasses import replace

import numpy as np

from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.lateness import velocities_at_m_s
from flight_replay.planning.fit.legs.flight_points import (
    FlightPoints,
    marks_of_flight,
    points_at_fixes,
    points_beside_fixes,
)
from flight_replay.planning.fit.legs.local_flights import LocalFlights
from flight_replay.planning.fit.reference import local_track
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, draft_of

NORTHWARDS = FlightPoints(
    0, np.array([0.0, 1.0, 2.0]), np.zeros((3, 2)), np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 0.0]])
)


def test_points_between_two_times_do_not_depend_on_last_bits() -> None:
    """The first time belongs to them, the second does not, give or take a microsecond."""
    assert NORTHWARDS.between(1.0, 2.0) == slice(1, 2)
    assert NORTHWARDS.between(1.0 + 1e-12, 2.0 - 1e-12) == slice(1, 2)
    assert NORTHWARDS.between(-1.0, 9.0) == slice(0, 3)


def test_only_what_is_across_the_path_counts() -> None:
    """All of a move where there is no path along which a point may slide."""
    across = NORTHWARDS.across(np.array([[3.0, 4.0], [3.0, 4.0]]), slice(1, 3))
    assert across.tolist() == [[0.0, 4.0], [3.0, 4.0]]


def test_a_flight_straight_on_has_points_that_may_slide_along_it() -> None:
    """A fix beside it and a mark on it move along their line; what is behind its end counts in full."""
    fixes = along([(0, 0), (100, 1)], 4.0)
    problem = problem_for(local_track(fixes, 20.0), 20, Limits(), timed=True)
    draft = replace(draft_of([(0, 0), (60, 0)], [False, False], [1, 0]), speed_m_s=np.array([np.nan, 4.0]))
    base = problem.evaluate(draft)
    flight = LocalFlights(problem, draft, 600.0).fly(base.draft, 1, 1)
    beside = points_beside_fixes(base, flight, 7)
    marks = marks_of_flight(problem, base, flight, 9)
    middle = len(problem.recording) // 3
    assert abs(beside.along[middle, 0]) > 0.999
    assert not beside.along[-1].any()
    assert np.abs(marks.along[5:-5, 0]).min() > 0.999
    assert (beside.row, marks.row) == (7, 9)
    at_fixes = points_at_fixes(problem, flight)
    speed_m_s = np.linalg.norm(velocities_at_m_s(flight.time_s, flight.north_east_m, at_fixes.time_s), axis=1)
    assert not at_fixes.along.any()
    assert 3.0 < speed_m_s[middle // 2] < 12.0

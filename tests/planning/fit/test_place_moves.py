"""Moving places: how far they may stray, and that moving them helps."""

import numpy as np
import pytest

from flight_replay.planning.fit.first_drafts.knot_selection import select_waypoints
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.objective import path_error_m
from flight_replay.planning.fit.place_moves import kept_in_corridor, shaped
from flight_replay.planning.fit.reference import Hover, local_track
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, draft_of, wander


def test_no_waypoint_is_farther_than_4_m_from_the_recording() -> None:
    """Places farther away are brought to 4 m, straight towards the recording; the others stay."""
    recording = local_track(along([(0, 0), (60, 0)], 4.0), 20.0)
    draft = draft_of([(0, 0), (20, 3.9), (40, -30), (60, 0)], [False, True, True, True], [1, 0, 0, 0])
    kept = kept_in_corridor(draft, {}, recording)
    assert kept.places_m[:, :2] == pytest.approx(np.array([[0, 0], [20, 3.9], [40, -4], [60, 0]]), abs=0.01)
    assert (kept.places_m[:, 2] == draft.places_m[:, 2]).all()


def test_a_place_to_wait_stays_within_1_m_of_the_hover() -> None:
    """It may not slide along the recording either, which costs no path error."""
    recording = local_track(along([(0, 0), (60, 0)], 4.0), 20.0)
    draft = draft_of([(0, 0), (25, 0), (60, 0)], [False, True, True], [1, 5, 0])
    kept = kept_in_corridor(draft, {1: Hover(20, 20, 5.0)}, recording)
    assert kept.places_m[1, :2] == pytest.approx([21.0, 0.0], abs=0.05)


def test_moving_the_places_lowers_the_path_error() -> None:
    """Four steps from a first draft fly nearer to a hand-flown way."""
    recording = local_track(wander(7), 20.0)
    problem = problem_for(recording, 15, Limits(), timed=False)
    start = problem.evaluate(select_waypoints(problem, 15).draft)
    found = shaped(problem, start, {}, 4, problem.evaluate)
    assert path_error_m(found.flown) < 0.8 * path_error_m(start.flown)

"""Lines reduced to their corners."""

import numpy as np
import pytest

from flight_replay.planning.fit.first_drafts.line_simplification import corner_draft, douglas_peucker
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.reference import LocalTrack
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import FRAME, along


def test_douglas_peucker_keeps_corners() -> None:
    """A line around three corners keeps them and its ends, and no more than asked."""
    line = along([(0, 0), (40, 0), (70, 40), (10, 120)], 2.0).north_east_m(FRAME)
    kept = douglas_peucker(line, 10)
    assert kept.tolist() == [0, 80, 180, 380]
    assert len(douglas_peucker(line, 3)) == 3


def test_a_line_has_no_more_corners_than_keep_it_near_and_those_that_are_kept() -> None:
    """A bend of a few centimetres is none, and a point on a straight line stays where it is asked to."""
    line = np.array([[0.0, 0.0], [10.0, 0.05], [20.0, 0.0], [30.0, 0.0], [30.0, 20.0]])
    assert douglas_peucker(line, 5, near_m=0.3).tolist() == [0, 3, 4]
    assert douglas_peucker(line, 5, near_m=0.3, kept=[2]).tolist() == [0, 2, 3, 4]


def test_a_mission_flown_is_long_straight_legs_stops_and_curves() -> None:
    """Ten seconds of climb on the spot, a leg, a pause of 3 s, and a leg that ends in a narrow turn."""
    climb = [(0.0, 0.0, 10.0 + 2.0 * i) for i in range(6)]
    leg = [(4.0 * i, 0.0, 20.0) for i in range(1, 11)]
    pause = [(40.0, 0.0, 20.0)] * 3
    back = [(40.0, 4.0 * i, 20.0) for i in range(1, 11)]
    turn = [(36.0 + 4.0 * np.cos(a), 40.0 + 4.0 * np.sin(a), 20.0) for a in np.linspace(0.3, 3.1, 8)]
    places_m = np.array([*climb, *leg, *pause, *back, *turn])
    time_s = np.arange(len(places_m), dtype=float)
    problem = problem_for(LocalTrack(time_s, places_m[:, :2], places_m[:, 2]), 20, Limits(), timed=True)
    start = corner_draft(problem, 20)
    draft = start.draft
    assert draft.places_m[:3].tolist() == [[0, 0, 10], [0, 0, 20], [40, 0, 20]]
    assert draft.places_m[3] == pytest.approx([40.0, 40.0, 20.0], abs=1.5)
    assert list(start.hovers) == [2]
    assert (draft.hold_s[:4] > 0).tolist() == [True, False, True, False]
    assert not draft.spline[:4].any()
    assert draft.spline[4:].all()
    assert len(draft) >= 6


def test_a_mission_of_two_places_has_no_room_for_pauses() -> None:
    """The ends are all there is."""
    places_m = np.repeat([[0.0, 0.0], [30.0, 0.0], [60.0, 0.0]], 10, axis=0)
    recording = LocalTrack(np.arange(30.0), places_m, np.full(30, 20.0))
    start = corner_draft(problem_for(recording, 2, Limits(), timed=True), 2)
    assert start.draft.places_m[:, 0].tolist() == [0.0, 60.0]
    assert not start.hovers

"""Which fixes become waypoints."""

import numpy as np
import pytest

from flight_replay.planning.fit.first_drafts.knot_selection import select_waypoints, selections
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.objective import path_error_m
from flight_replay.planning.fit.offsets import match_to_plan
from flight_replay.planning.fit.problem import FirstDraft
from flight_replay.planning.fit.reference import local_track
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import FRAME, along, circle, track_through, wander


def selected(track, most: int, *, timed: bool = False) -> FirstDraft:  # type: ignore[no-untyped-def]
    return select_waypoints(problem_for(local_track(track, 20.0), most, Limits(), timed=timed), most)


def test_simple_ways_need_fewer_places() -> None:
    """A straight line needs two places, a circle some, a hand-flown way most."""
    ways = along([(0, 0), (100, 0)], 5.0), circle(), wander(2, fixes=200)
    counts = [len(selected(track, 40).draft) for track in ways]
    assert counts[0] == 2
    assert 4 < counts[1] < 35
    assert 35 <= counts[2] <= 40


def test_places_stand_closer_where_the_way_curves() -> None:
    """More than half of the places go to the curved half of a way."""
    straight = np.column_stack([np.linspace(-120, 0, 100), np.zeros(100)])
    turn = np.linspace(0, 6 * np.pi, 100)
    loops = np.column_stack([6.4 * np.sin(turn), 6.4 * (1 - np.cos(turn))])
    track = track_through(np.concatenate([straight, loops]), np.arange(200.0) / 3)
    assert (selected(track, 30).draft.places_m[:, 0] > -7).sum() > 15


def test_a_hover_is_a_place_to_wait() -> None:
    """Half a minute at one place between two legs is one place with as long a hold, where it was."""
    out, back = along([(0, 0), (60, 0)], 4.0), along([(60, 0), (60, 60)], 4.0)
    way = np.concatenate([out.north_east_m(FRAME), np.tile([60.0, 0.0], (120, 1)), back.north_east_m(FRAME)])
    start = selected(track_through(way, np.arange(len(way)) / 4.0), 20, timed=True)
    (place,) = start.hovers
    assert abs(start.draft.hold_s[place] - 30) <= 1
    assert np.linalg.norm(start.draft.places_m[place, :2] - [60.0, 0.0]) <= 1.0


def test_a_descent_on_the_spot_begins_and_ends_at_places() -> None:
    """Above one point of the ground the way turns from level to straight down: no leg cuts that corner."""
    out = np.column_stack([np.linspace(0.0, 60.0, 61), np.zeros(61)])
    way = np.vstack([out, np.tile(out[-1], (12, 1))])
    up_m = np.append(np.full(61, 20.0), 20.0 - np.arange(1.0, 13.0))
    recording = local_track(track_through(way, np.arange(73.0) / 2, up_m), up_m)
    problem = problem_for(recording, 20, Limits(), timed=True)
    places_m = select_waypoints(problem, 20).draft.places_m
    corner = np.linalg.norm(places_m - [60.0, 0.0, 20.0], axis=1).argmin()
    assert places_m[corner] == pytest.approx([60.0, 0.0, 20.0], abs=1.5)
    assert corner < len(places_m) - 1
    assert places_m[: corner + 1, 2].min() > 18.0


def test_where_there_are_too_many_places_for_the_time_the_drafts_have_fewer() -> None:
    """Legs of less than about two seconds slow a vehicle: 60 s are flown in about 30 legs, on four ways."""
    track = wander(2, fixes=120)
    few = selections(problem_for(local_track(track, 20.0), 80, Limits(), timed=True), 80)
    assert all(len(start.draft) < 40 for start in few)
    assert len({start.draft.places_m.tobytes() for start in few}) == 4


def test_where_there_is_time_for_all_places_one_draft_has_fewer_and_one_more() -> None:
    """Stretches of the one pay for those of the other."""
    track = wander(2, fixes=200)
    starts = selections(problem_for(local_track(track, 20.0), 20, Limits(), timed=True), 20)
    assert [len(start.draft) for start in starts] == [20, 17, 23]


def test_waypoints_of_a_fix_a_second_do_not_swing_out_of_the_recording() -> None:
    """Moved towards fixes 9 m apart, curves may leave the line between them: then they stay."""
    corners = [(0.0, 0.0), *((8.0 * turn, 60.0 * (turn % 2)) for turn in range(1, 13))]
    recording = local_track(along(corners, 9.0, rate_hz=1.0), 20.0)
    draft = select_waypoints(problem_for(recording, 40, Limits(), timed=False), 40).draft
    assert path_error_m(match_to_plan(draft, recording)) < 0.4

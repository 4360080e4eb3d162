"""curves.py: what pictures of a replay show."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.distances import path_errors_m
from flight_replay.logs.track import track_from_columns
from flight_replay.mission.items import Command, Mission
from flight_replay.output.charts.series import MOST_POINTS, curves, ground_speed_m_s, peaks, thinned
from flight_replay.planning.route import route_of
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_replays import eight, replay


def test_both_clocks_start_at_nought() -> None:
    """Recorded time counts from the first fix, flown time from the first waypoint."""
    shown = curves(*replay())
    assert shown.recorded.time_s[0] == 0
    assert shown.flown is not None
    assert shown.flown.time_s[0] == pytest.approx(-2.0)
    assert shown.reached[0] == (0.0, 30.0)
    assert len(shown.reached) == len(shown.waypoint_seqs) - 1


def test_everything_lies_in_one_metric_frame() -> None:
    """The first fix is the origin; the flown eight is a metre aside where it was made so."""
    shown = curves(*replay())
    assert np.allclose(shown.recorded.north_east_m[0], 0)
    assert np.allclose(shown.waypoints_m[0], 0, atol=1e-3)
    assert shown.flown is not None
    assert np.allclose(shown.flown.north_east_m[0], [1, 0], atol=1e-3)
    assert shown.in_space is not None
    assert shown.in_space.spread.max == pytest.approx(shown.in_space.distance_m.max())


def test_spline_legs_are_drawn_as_curves_with_few_points() -> None:
    """The line bends beyond the waypoints' chords, within 5 cm of the exact curve."""
    route, _, _ = replay()
    splines = tuple(replace(item, command=Command.SPLINE_WAYPOINT) for item in route.mission.items[::6])
    curved = route_of("made", Mission(splines), route.covered)
    drawn = curves(curved).planned_m
    assert 5 * len(splines) < len(drawn) < len(curved.path.north_east_m) / 3
    assert path_errors_m(curved.path.north_east_m, drawn).max() < 0.05


def test_a_plan_alone_has_no_flown_curves() -> None:
    """What there is nothing of is None."""
    shown = curves(replay()[0])
    assert (shown.flown, shown.in_space, shown.in_time, shown.reached) == (None, None, None, ())
    assert shown.planned_distance.spread.max < 1


def test_items_that_are_no_waypoints_do_not_count_as_reached() -> None:
    """A speed change has no place; the first waypoint unreached, AUTO's begin starts the clock."""
    _, record, _ = replay()
    route = spaced_route(eight(), spacing_m=6.0, max_points=60, speed_m_s=3.0)
    shown = curves(route, record)
    assert shown.waypoint_seqs[0] == 2
    assert shown.reached[0] == (0.0, 30.0)
    assert len(shown.reached) == len(record.reached) - 1


def test_long_tracks_are_thinned_but_keep_their_ends() -> None:
    """At most so many points are drawn."""
    keep = thinned(1_000_000)
    assert len(keep) == MOST_POINTS
    assert (keep[0], keep[-1]) == (0, 999_999)
    assert thinned(3).tolist() == [0, 1, 2]
    assert thinned(1).tolist() == [0]


def test_no_peak_is_lost_to_thinning() -> None:
    """The highest distance is drawn however long the flight was."""
    values = np.zeros(100_001)
    values[77_777] = 9.0
    assert 77_777 in peaks(values)
    assert len(peaks(values)) == MOST_POINTS
    assert peaks(np.zeros(3)).tolist() == [0, 1, 2]


def test_speed_is_the_vehicles_own_or_that_of_its_places() -> None:
    """Where the log tells no velocity, distance over time does; equal times make no infinite speed."""
    track = eight()
    own = ground_speed_m_s(track, track.north_east_m())
    bare = track_from_columns(track.time_s, track.lat_deg, track.lon_deg, track.alt_m)
    assert np.allclose(ground_speed_m_s(bare, bare.north_east_m()), own, atol=0.2)
    still = track_from_columns(np.zeros(2), track.lat_deg[:2], track.lon_deg[:2], track.alt_m[:2])
    assert ground_speed_m_s(still, still.north_east_m()).tolist() == [0, 0]
    one = bare.select(slice(0, 1))
    assert ground_speed_m_s(one, one.north_east_m()).tolist() == [0]

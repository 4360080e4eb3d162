"""series.py: the series that charts draw."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.matching import match_in_order
from flight_replay.logs.track import track_from_columns
from flight_replay.mission.items import Command, Mission
from flight_replay.output.charts.series import (
    MAX_CHART_POINTS,
    ground_speed_m_s,
    peak_indices,
    replay_series,
    thin_indices,
)
from flight_replay.planning.prediction import with_prediction
from flight_replay.planning.route import route_of
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_replays import figure_of_eight, made_following, made_replay


def test_both_times_start_at_0() -> None:
    """Recorded time counts from the first fix, flown time from the first waypoint."""
    series = replay_series(*made_replay())
    assert series.recorded.time_s[0] == 0
    assert series.flown is not None
    assert series.flown.time_s[0] == pytest.approx(-2.0)
    assert series.reached[0] == (0.0, 30.0)
    assert len(series.reached) == len(series.waypoint_seqs) - 1


def test_everything_lies_in_one_metric_frame() -> None:
    """The first fix is the origin; the flown path starts a metre beside it."""
    series = replay_series(*made_replay())
    assert np.allclose(series.recorded.north_east_m[0], 0)
    assert np.allclose(series.waypoints_m[0], 0, atol=1e-3)
    assert series.flown is not None
    assert np.allclose(series.flown.north_east_m[0], [1, 0], atol=1e-3)
    path_error = series.flown_error.path
    assert path_error is not None
    for errors in (path_error.recorded_to_path, path_error.path_to_recorded):
        assert errors is not None
        assert errors.statistics.max == pytest.approx(errors.error.max())


def test_a_recording_without_times_is_not_drawn_over_time() -> None:
    """Its line is, but it has no speed, and its heights no time; labels say what its errors are over."""
    series = replay_series(spaced_route(replace(figure_of_eight(), timed=False), spacing_m=6.0))
    assert series.recorded_lines
    assert not series.timed_lines
    assert [len(values) for values in series.planned_height] == [0, 0]
    assert series.time_label == "time since the first waypoint (s)"
    assert series.error_label == "way along the recording (s at 5 m/s)"


def test_what_is_not_covered_is_there_too() -> None:
    """The whole recording, and of it what the flight reached, or what the plan covers."""
    route, outcome = made_replay()
    series = replay_series(route, outcome)
    assert len(series.recording.time_s) == 300
    assert len(series.recorded.time_s) == outcome.coverage.fixes < 300
    part = spaced_route(figure_of_eight(), spacing_m=6.0, max_points=10)
    plan = replay_series(part)
    assert len(plan.recording.time_s) == 300
    assert len(plan.recorded.time_s) == len(part.covered) < 100
    assert [name for name, _ in plan.recorded_lines] == ["recorded, not covered", "recorded"]
    whole = replay_series(spaced_route(figure_of_eight(), max_points=500))
    assert [name for name, _ in whole.recorded_lines] == ["recorded"]


def test_spline_legs_are_drawn_as_curves_with_few_points() -> None:
    """The drawn line is within 5 cm of the exact curve."""
    route, _ = made_replay()
    splines = tuple(replace(item, command=Command.SPLINE_WAYPOINT) for item in route.mission.items[::6])
    curved = route_of("made", Mission(splines), route.covered)
    drawn = replay_series(curved).planned_m
    assert 5 * len(splines) < len(drawn) < len(curved.path.north_east_m) / 3
    assert match_in_order(curved.path.north_east_m, drawn).distance_m.max() < 0.05


def test_what_is_followed_is_on_one_clock() -> None:
    """Recorded and flown are on the reference's: at half the pace, and where it waited, at equal times."""
    series = replay_series(*made_following(pace=0.5, waits_at_s=30.0, waits_s=4.0))
    assert series.time_label == "time of the recording at 0.5x (s)"
    recorded, flown = series.recorded, series.flown
    assert flown is not None
    assert series.recording.time_s[-1] == pytest.approx(2 * 0.4 * 299)
    apart_m = [
        np.interp(flown.time_s, recorded.time_s, recorded.north_east_m[:, axis]) - flown.north_east_m[:, axis]
        for axis in (0, 1)
    ]
    assert np.hypot(*apart_m)[flown.time_s >= 0].max() < 2.0
    assert recorded.speed_m_s[100] == pytest.approx(
        ground_speed_m_s(figure_of_eight(), np.zeros((300, 2)))[100] / 2
    )


def test_times_are_named() -> None:
    """By what they count from."""
    assert replay_series(made_replay()[0]).time_label == "time since the first fix / first waypoint (s)"
    assert replay_series(made_following()[0]).time_label == "time of the recording (s)"


def test_a_plan_has_no_flown_series() -> None:
    """What does not exist is None."""
    series = replay_series(made_replay()[0])
    assert (series.flown, series.reached) == (None, ())
    none = series.flown_error
    assert (none.path, none.position, none.height, none.heading) == (None, None, None, None)
    planned = series.planned_error
    assert planned.recorded_to_path is not None and planned.recorded_to_path.statistics.max < 1
    assert planned.path_to_recorded is not None and planned.path_to_recorded.statistics.max < 1


def test_a_plan_has_heights_and_what_is_predicted() -> None:
    """By the clock of the errors: the first waypoint is reached at 0, at the height of take-off."""
    route, outcome = made_replay()
    route = with_prediction(route, 30.0)
    series = replay_series(route)
    times_s, heights_m = series.planned_height
    assert (times_s[0], times_s[-1]) == pytest.approx((0.0, 0.4 * 299))
    assert set(heights_m) == {30.0}
    assert series.predicted is not None and series.predicted_unflown is series.predicted
    at_first = np.interp(0.0, series.predicted.time_s, np.hypot(*series.predicted.north_east_m.T))
    assert at_first < 3.0
    assert 1.0 < series.predicted.speed_m_s.max() < 10.5
    assert series.shown_error.position is not None
    assert series.shown_error.path is not None
    flown = replay_series(route, outcome)
    assert flown.predicted_unflown is None
    assert flown.shown_error.position is flown.flown_error.position


def test_only_waypoints_count_as_reached() -> None:
    """Waits and speed changes do not. Before the first waypoint, time counts from the start of AUTO."""
    _, outcome = made_replay()
    route = spaced_route(figure_of_eight(), spacing_m=6.0, max_points=60, speed_m_s=3.0)
    series = replay_series(route, outcome)
    assert series.waypoint_seqs[0] == 3
    assert series.reached[0] == (0.0, 30.0)
    assert len(series.reached) == len(outcome.record.reached) - 2


def test_long_tracks_are_thinned_but_keep_their_ends() -> None:
    """At most MAX_CHART_POINTS points are drawn."""
    keep = thin_indices(1_000_000)
    assert len(keep) == MAX_CHART_POINTS
    assert (keep[0], keep[-1]) == (0, 999_999)
    assert thin_indices(3).tolist() == [0, 1, 2]
    assert thin_indices(1).tolist() == [0]


def test_no_peak_is_lost_to_thinning() -> None:
    """The maximum is drawn however long the flight was."""
    values = np.zeros(100_001)
    values[77_777] = 9.0
    assert 77_777 in peak_indices(values)
    assert len(peak_indices(values)) == MAX_CHART_POINTS
    assert peak_indices(np.zeros(3)).tolist() == [0, 1, 2]


def test_speed_is_the_recorded_one_or_distance_over_time() -> None:
    """Without a recorded velocity it is distance over time; equal times give no infinite speed."""
    track = figure_of_eight()
    own = ground_speed_m_s(track, track.north_east_m())
    bare = track_from_columns(track.time_s, track.lat_deg, track.lon_deg, track.alt_m)
    assert np.allclose(ground_speed_m_s(bare, bare.north_east_m()), own, atol=0.2)
    still = track_from_columns(np.zeros(2), track.lat_deg[:2], track.lon_deg[:2], track.alt_m[:2])
    assert ground_speed_m_s(still, still.north_east_m()).tolist() == [0, 0]
    one = bare.select(slice(0, 1))
    assert ground_speed_m_s(one, one.north_east_m()).tolist() == [0]


def test_a_recording_that_is_followed_has_no_waypoints() -> None:
    """The planned line is the reference; flown time counts from the recording's first fix."""
    route, outcome = made_following()
    series = replay_series(route, outcome)
    assert (series.waypoint_seqs, series.waypoints_m.shape, series.reached) == ((), (0, 2), ())
    assert series.planned_m is route.path.north_east_m
    assert series.flown is not None
    assert series.flown.time_s[0] == pytest.approx(-5.0, abs=0.11)

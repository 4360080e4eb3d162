"""outcome.py: path error and position error of a flight."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.error_statistics import ErrorStatistics
from flight_replay.geometry.flight_errors import Errors
from flight_replay.logs.track import track_from_columns
from flight_replay.output.outcome import compare_flight
from flight_replay.planning.route import Route
from flight_replay.planning.spacing import spaced_route
from flight_replay.supervisor.flight_plan import FlightRecord
from tests.helpers.made_replays import made_following
from tests.helpers.made_tracks import FRAME, straight_track


def flight(route: Route, waypoints: int, aside_m: float = 0.0, late_s: float = 0.0) -> FlightRecord:
    """A flight along the straight track at 4 m/s, from 20 m before it to waypoint ``waypoints``."""
    seconds = np.arange(0, waypoints - 1 + 1e-9 + 5, 0.1)
    north_m = (seconds - 5) * 4.0
    lat, lon = FRAME.to_degrees(np.column_stack([north_m, np.full(len(seconds), aside_m)]))
    return FlightRecord(
        waypoints_reached=waypoints,
        ended="duration",
        problem=None,
        auto_start_s=100.0,
        auto_s=float(seconds[-1]),
        rtl_confirmed=True,
        landed=False,
        reached=tuple((seq, 100 + 5 + (seq - 1) - late_s) for seq in range(1, waypoints + 1)),
        flown=track_from_columns(100 + seconds, lat, lon, np.zeros(len(seconds))),
    )


def statistics(errors: Errors) -> ErrorStatistics:
    """Of errors that exist."""
    found = errors.statistics
    assert found is not None
    return found


def test_a_perfect_replay_has_no_error() -> None:
    """The same path at the same times has no path error, either way, and no position error."""
    route = spaced_route(straight_track(), altitude_m=0.0)
    outcome = compare_flight(route, flight(route, 51))
    errors = outcome.errors
    assert statistics(errors.path_m.recorded_to_path).max < 0.01
    assert statistics(errors.path_m.path_to_recorded).max < 0.01
    assert statistics(errors.position_m).max < 0.01
    assert statistics(errors.height_m).max < 0.01
    assert len(errors.path_m.recorded_to_path) == len(errors.position_m) == 51
    assert outcome.coverage.fly_all == ()


def test_heights_are_compared_with_the_commanded_ones() -> None:
    """A flight on the ground that was to fly at 30 m is 30 m too low."""
    route = spaced_route(straight_track(), altitude_m=30.0)
    assert statistics(compare_flight(route, flight(route, 51)).errors.height_m).mean == pytest.approx(30.0)


def test_a_late_flight_has_a_position_error_only() -> None:
    """3 m beside the path is a path error of 3 m; 2 s late at 4 m/s is a position error of 8 m."""
    route = spaced_route(straight_track())
    beside = compare_flight(route, flight(route, 51, aside_m=3.0)).errors.path_m
    assert statistics(beside.recorded_to_path).mean == pytest.approx(3.0, abs=0.01)
    assert statistics(beside.path_to_recorded).mean == pytest.approx(3.0, abs=0.01)
    late = compare_flight(route, flight(route, 51, late_s=2.0)).errors
    assert statistics(late.path_m.recorded_to_path).max < 0.01
    assert statistics(late.position_m).mean == pytest.approx(8.0, abs=0.01)


def test_headings_are_compared_where_both_are_known() -> None:
    """350 and 20 degrees are 30 apart; a recording without headings says why there is no error."""
    route = spaced_route(straight_track())
    record = flight(route, 51)
    flown = replace(record.flown, heading_deg=np.full(len(record.flown), 20.0))
    headed = replace(straight_track(), heading_deg=np.full(51, 350.0))
    outcome = compare_flight(spaced_route(headed), replace(record, flown=flown))
    assert statistics(outcome.errors.heading_deg).max == pytest.approx(30.0)
    assert outcome.not_measured == {}
    unknown = compare_flight(route, replace(record, flown=flown))
    assert unknown.not_measured == {"heading_error_deg": "one of both flights has no heading"}


def test_a_short_flight_is_compared_up_to_its_last_waypoint() -> None:
    """Fixes after the last waypoint reached do not count; what flies all of it is told."""
    route = spaced_route(straight_track())
    outcome = compare_flight(route, flight(route, 11))
    assert len(outcome.errors.path_m.recorded_to_path) == 11
    assert statistics(outcome.errors.path_m.recorded_to_path).max < 0.01
    assert outcome.errors.path_m.place_m[-1] == pytest.approx([40.0, 0.0], abs=0.5)
    coverage = outcome.coverage
    assert (coverage.fixes, coverage.of_fixes, coverage.recorded_s, coverage.of_recorded_s) == (
        11,
        51,
        10,
        50,
    )
    assert coverage.fly_all == ("--duration all",)


def test_a_climb_on_the_spot_is_flown_as_far_as_it_was_flown() -> None:
    """Over the ground all of it is at the first waypoint; in space a third of it was reached."""
    track = straight_track(0.0, 61, np.linspace(5.0, 35.0, 61).tolist())
    route = spaced_route(track, altitude_m="recorded")
    coverage = compare_flight(route, flight(route, 4)).coverage
    assert coverage.recorded_s == pytest.approx(20.0, abs=2.0)
    assert coverage.fly_all == ("--duration all",)


def test_a_route_that_covers_a_part_needs_another_route() -> None:
    """Ten waypoints of 51: flying all of them is not flying all of the recording."""
    route = spaced_route(straight_track(), max_points=10)
    coverage = compare_flight(route, flight(route, 10)).coverage
    assert (coverage.fixes, coverage.fly_all) == (10, ("--route fit", "--duration all"))


def test_an_overshoot_shows_in_one_way_only() -> None:
    """A detour of 5 m between two waypoints passes every fix, but is far from the recording."""
    route = spaced_route(straight_track())
    record = flight(route, 51)
    north_east_m = record.flown.north_east_m(FRAME)
    detour = np.array([[100.0, 0.0], [102.0, 5.0], [104.0, 0.0]])
    at = int(np.searchsorted(north_east_m[:, 0], 101.0))
    lat, lon = FRAME.to_degrees(np.insert(north_east_m, at, detour, axis=0))
    time_s = np.insert(record.flown.time_s, at, np.full(3, record.flown.time_s[at]))
    flown = track_from_columns(time_s, lat, lon, np.zeros(len(lat)))
    path = compare_flight(route, replace(record, flown=flown)).errors.path_m
    assert statistics(path.recorded_to_path).max < 0.01
    assert statistics(path.path_to_recorded).max == pytest.approx(5.0, abs=0.15)


@pytest.mark.parametrize("positions", [0, 1, 400])
def test_a_flight_that_reached_no_waypoint_has_no_error(positions: int) -> None:
    """There is no time to compare from, and no part of the path that was flown."""
    route = spaced_route(straight_track())
    record = flight(route, 0) if positions > 1 else flight(route, 51)
    record = replace(record, reached=(), flown=record.flown.select(slice(positions)))
    outcome = compare_flight(route, record)
    assert outcome.errors.position_m.statistics is None
    assert outcome.errors.path_m.recorded_to_path.statistics is None
    assert outcome.errors.path_m.path_to_recorded.statistics is None
    assert len(outcome.not_measured) == 4
    assert outcome.coverage.recorded_s == 0.0


def test_a_recording_of_one_fix_is_compared() -> None:
    """A hover of one fix has errors like any other."""
    route = spaced_route(straight_track(fixes=1))
    record = replace(flight(route, 11), reached=((1, 105.0),))
    outcome = compare_flight(route, record)
    assert statistics(outcome.errors.path_m.recorded_to_path).max < 0.01
    assert len(outcome.errors.position_m) == 1
    assert outcome.coverage.fly_all == ()


def test_a_flight_that_ended_at_its_first_waypoint_has_true_reasons() -> None:
    """It has no time in common with the recording, which has heights; one path error is there."""
    route = spaced_route(straight_track())
    record = flight(route, 11)
    early = record.flown.select(record.flown.time_s < record.reached[0][1])
    outcome = compare_flight(route, replace(record, reached=record.reached[:1], flown=early))
    assert len(outcome.errors.path_m.recorded_to_path)
    no_time = "there is no time that both flights have"
    assert outcome.not_measured == {
        "path_error_m": "flown to recorded: no position between the first waypoint and the last one reached",
        "position_error_m": no_time,
        "height_error_m": no_time,
        "heading_error_deg": no_time,
    }


def test_a_flight_without_positions_is_compared() -> None:
    """Waypoints can be reported reached though no position was received."""
    route = spaced_route(straight_track())
    record = flight(route, 11)
    outcome = compare_flight(route, replace(record, flown=record.flown.select(slice(0))))
    assert outcome.errors.position_m.statistics is None
    assert "path_error_m" in outcome.not_measured


def test_a_flight_in_step_is_compared_by_the_recordings_clock() -> None:
    """A metre beside the reference is a metre at equal times, which need no waypoint."""
    route, outcome = made_following()
    errors = outcome.errors
    assert statistics(errors.position_m).mean == pytest.approx(1.0, abs=0.1)
    assert statistics(errors.height_m).max < 0.01
    assert errors.position_m.time_s[0] == 0.0
    assert outcome.first_waypoint_s == pytest.approx(1005.0, abs=0.1)
    assert outcome.waited_s == pytest.approx(0.0, abs=1e-6)
    assert outcome.not_measured == {"heading_error_deg": "one of both flights has no heading"}
    coverage = outcome.coverage
    assert coverage.recorded_s == pytest.approx(110.0, abs=0.5)
    assert coverage.of_fixes == len(route.recording) == 300
    assert coverage.fly_all == ("--duration all",)


def test_what_is_flown_beyond_the_last_fix_has_no_error() -> None:
    """The vehicle is on its way as the recording ends, and comes to rest behind that."""
    route, outcome = made_following(end_s=152.0)
    record = outcome.record
    assert record.recording_s is not None and record.recording_s[-1] > route.wanted.time_s[-1] + 1.0
    ends_m = outcome.errors.path_m.place_m[-1] - route.wanted.north_east_m[-1]
    beyond_m = record.flown.north_east_m(route.frame)[-1] - route.wanted.north_east_m[-1]
    assert np.linalg.norm(ends_m) < 1.2 < np.linalg.norm(beyond_m)


def test_waiting_is_no_error_but_is_told() -> None:
    """A recording that waits 7 s has the same errors as one that does not."""
    _, free = made_following()
    _, waited = made_following(waits_at_s=40.0, waits_s=7.0)
    assert waited.waited_s == pytest.approx(7.0, abs=0.1)
    assert statistics(waited.errors.position_m).max == pytest.approx(
        statistics(free.errors.position_m).max, abs=0.05
    )
    assert len(waited.errors.position_m) == len(free.errors.position_m)


def test_after_a_rejoin_the_second_time_over_counts() -> None:
    """A clock that goes back 4 s makes times that rise, and no fix is compared twice."""
    _, outcome = made_following(waits_at_s=40.0, waits_s=3.0, back_s=4.0)
    record = outcome.record
    assert record.recording_s is not None and np.diff(record.recording_s).min() < -3.0
    assert outcome.waited_s == pytest.approx(7.0, abs=0.2)
    times_s = outcome.errors.position_m.time_s
    assert np.all(np.diff(times_s) > 0)
    assert statistics(outcome.errors.position_m).max < 2.0


def test_a_follower_that_never_began_has_no_error() -> None:
    """It was stopped during the run-up: the reason is told in words of following."""
    route, outcome = made_following()
    record = outcome.record
    assert record.recording_s is not None
    begun = int(np.searchsorted(record.recording_s, -0.5))
    early = replace(record, flown=record.flown.select(slice(begun)), recording_s=record.recording_s[:begun])
    outcome = compare_flight(route, early)
    assert outcome.errors.position_m.statistics is None
    assert set(outcome.not_measured.values()) == {"the first fix was not reached"}
    assert outcome.waited_s == 0.0


def test_a_slower_replay_covers_recorded_seconds() -> None:
    """At half the pace the coverage is still in the recording's seconds."""
    route, outcome = made_following()
    record = outcome.record
    slow = replace(route, wanted=replace(route.wanted, time_s=2.0 * route.wanted.time_s))
    assert compare_flight(slow, record).coverage.recorded_s == pytest.approx(55.0, abs=0.5)


def test_the_clocks_are_put_on_each_other_between_two_positions() -> None:
    """The vehicle's time at the first fix, not that of its next position."""
    route, outcome = made_following()
    record = outcome.record
    assert record.recording_s is not None
    outcome = compare_flight(route, replace(record, recording_s=record.recording_s + 0.04))
    assert outcome.first_waypoint_s == pytest.approx(1004.96)

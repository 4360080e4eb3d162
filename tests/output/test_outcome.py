"""outcome.py: path error and position error of a flight."""

import numpy as np
import pytest

from flight_replay.logs.track import track_from_columns
from flight_replay.output.outcome import compare_flight
from flight_replay.planning.route import Route
from flight_replay.planning.spacing import spaced_route
from flight_replay.supervisor.flight_plan import FlightRecord
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


def test_a_perfect_replay_has_no_error() -> None:
    """The same path at the same times has a path error and a position error of 0."""
    route = spaced_route(straight_track())
    outcome = compare_flight(route, flight(route, 51))
    assert outcome.path_error is not None and outcome.path_error.max < 0.01
    assert outcome.position_error is not None and outcome.position_error.max < 0.01
    assert len(outcome.path_errors_m) == len(outcome.position_errors_m) == 51


def test_a_late_flight_has_a_position_error_only() -> None:
    """3 m beside the path is a path error of 3 m; 2 s late at 4 m/s is a position error of 8 m."""
    route = spaced_route(straight_track())
    beside = compare_flight(route, flight(route, 51, aside_m=3.0))
    assert beside.path_error is not None and beside.path_error.mean == pytest.approx(3.0, abs=0.01)
    late = compare_flight(route, flight(route, 51, late_s=2.0))
    assert late.path_error is not None and late.path_error.max < 0.01
    assert late.position_error is not None and late.position_error.mean == pytest.approx(8.0, abs=0.01)


def test_a_short_flight_is_compared_up_to_its_last_waypoint() -> None:
    """Fixes after the last waypoint reached do not count."""
    route = spaced_route(straight_track())
    outcome = compare_flight(route, flight(route, 11))
    assert len(outcome.path_errors_m) == 11
    assert outcome.path_error is not None and outcome.path_error.max < 0.01


def test_a_flight_that_reached_no_waypoint_has_no_position_error() -> None:
    """There is no time to compare from."""
    route = spaced_route(straight_track())
    record = flight(route, 0)
    outcome = compare_flight(route, record)
    assert outcome.position_error is None

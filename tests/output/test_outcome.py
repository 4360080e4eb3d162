"""A flight is measured against what it was due to fly."""

import numpy as np
import pytest

from flight_replay.logs.track import track_from_columns
from flight_replay.output.outcome import compare_flight
from flight_replay.planning.route import Route
from flight_replay.planning.spacing import spaced_route
from flight_replay.supervisor.flight_plan import FlightRecord
from tests.helpers.made_tracks import FRAME, dash


def flight(route: Route, waypoints: int, aside_m: float = 0.0, late_s: float = 0.0) -> FlightRecord:
    """A flight along the dash at 4 m/s, from 20 m before it, that got to so many waypoints."""
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


def test_a_perfect_replay_has_no_distance() -> None:
    """The same path at the same times is 0 m away in space and in time."""
    route = spaced_route(dash())
    outcome = compare_flight(route, flight(route, 51))
    assert outcome.in_space is not None and outcome.in_space.max < 0.01
    assert outcome.in_time is not None and outcome.in_time.max < 0.01
    assert len(outcome.space_m) == len(outcome.time_m) == 51


def test_distances_tell_aside_from_late() -> None:
    """A path 3 m beside is 3 m off in space; one 2 s late at 4 m/s is 8 m off in time, not in space."""
    route = spaced_route(dash())
    beside = compare_flight(route, flight(route, 51, aside_m=3.0))
    assert beside.in_space is not None and beside.in_space.mean == pytest.approx(3.0, abs=0.01)
    late = compare_flight(route, flight(route, 51, late_s=2.0))
    assert late.in_space is not None and late.in_space.max < 0.01
    assert late.in_time is not None and late.in_time.mean == pytest.approx(8.0, abs=0.01)


def test_a_flight_cut_short_is_held_to_what_it_reached() -> None:
    """Fixes behind the last waypoint reached were never due."""
    route = spaced_route(dash())
    outcome = compare_flight(route, flight(route, 11))
    assert len(outcome.space_m) == 11
    assert outcome.in_space is not None and outcome.in_space.max < 0.01


def test_nothing_reached_is_nothing_compared() -> None:
    """A flight that reached no waypoint has no distances, rather than wrong ones."""
    route = spaced_route(dash())
    record = flight(route, 0)
    outcome = compare_flight(route, record)
    assert outcome.in_time is None

"""data.py: the data of the live map."""

import math

import numpy as np
import pytest

from flight_replay.events import DistanceToWaypoint, Finished, Following, Phase, PhaseStarted, WaypointReached
from flight_replay.output.live_map.data import LivePathError, MapData
from tests.helpers.made_replays import FRAME, figure_of_eight, made_following, made_replay, vehicle_at


@pytest.fixture
def data() -> MapData:
    """The map data of the made-up replay."""
    return MapData(made_replay()[0])


def test_errors_start_at_the_first_waypoint(data: MapData) -> None:
    """Before it, and outside AUTO, errors are NaN."""
    data.listener(vehicle_at(1, 0, 50.0))
    data.listener(WaypointReached(1, 60.0))
    data.listener(vehicle_at(0, 0, 60.0))
    data.listener(vehicle_at(0, 0, 61.0, mode="RTL"))
    before, at_first, home = data.points(0)
    assert math.isnan(before.elapsed_s)
    assert at_first.elapsed_s == 0
    assert at_first.path_error_m == pytest.approx(0, abs=1e-3)
    assert at_first.position_error_m == pytest.approx(0, abs=1e-3)
    assert math.isnan(home.path_error_m)
    assert [before.north_m, before.east_m] == pytest.approx([1, 0], abs=1e-3)


def test_position_error_is_that_of_equal_times(data: MapData) -> None:
    """A vehicle that flies the same path 10 % slower falls behind by as much."""
    recorded, slow = figure_of_eight(), figure_of_eight(slower=1.1)
    data.listener(WaypointReached(1, 100.0))
    for n in range(0, 300, 5):
        north_m, east_m = slow.north_east_m(FRAME)[n]
        data.listener(vehicle_at(north_m, east_m, float(slow.time_s[n])))
    points = data.points(0)
    recorded_m = recorded.north_east_m(FRAME)
    expected_m = [
        np.interp(points[20].elapsed_s + 100, recorded.time_s, recorded_m[:, axis]) for axis in (0, 1)
    ]
    assert points[20].position_error_m == pytest.approx(
        math.dist(expected_m, slow.north_east_m(FRAME)[100]), abs=0.01
    )
    assert math.isnan(points[-1].position_error_m)
    assert max(point.path_error_m for point in points) < 0.05


def test_a_crossing_path_is_matched_in_order() -> None:
    """At the crossing of the eight, the vehicle is matched to the branch that it flies."""
    path = figure_of_eight().north_east_m(FRAME)
    path_error = LivePathError(path)
    errors_m = [path_error.update(position_m + np.array([0.0, 2.0])) for position_m in path]
    assert max(errors_m) <= 2.001


def test_a_sharp_turn_is_matched_in_order() -> None:
    """Just before a turn back, the leg after it is near too; the error stays right."""
    out = np.column_stack([np.linspace(0, 50, 101), np.zeros(101)])
    back = np.column_stack([np.linspace(50, 0, 101), np.full(101, 0.5)])
    path_error = LivePathError(np.vstack([out, back]))
    positions_m = np.vstack([out, back]) + np.array([0.0, 0.4])
    assert max(path_error.update(position_m) for position_m in positions_m) < 0.6


def test_a_part_that_is_left_out_is_passed() -> None:
    """A fitted route may leave out a spur of the recorded path, which goes on behind it."""
    line = np.column_stack([np.linspace(0, 100, 201), np.zeros(201)])
    spur = np.column_stack([np.full(81, 50.0), 20 - np.abs(np.linspace(-20, 20, 81))])
    path_error = LivePathError(np.vstack([line[:101], spur, line[101:]]))
    errors_m = [path_error.update(place_m) for place_m in line]
    assert max(errors_m) < 15.0
    assert max(errors_m[-60:]) < 0.01


def test_a_single_fix_is_a_path() -> None:
    """A log of a hover has a map too."""
    assert LivePathError(np.zeros((1, 2))).update(np.array([3.0, 4.0])) == pytest.approx(5)


def test_the_current_waypoint_is_the_one_flown_to(data: MapData) -> None:
    """Items without a position have none, and there is none after the flight."""
    assert data.target() is None
    data.listener(DistanceToWaypoint(1, 3.0, 60))
    target = data.target()
    assert target is not None
    assert (target.north_m, target.east_m) == pytest.approx((0, 0), abs=1e-3)
    assert target.label == "1"
    data.listener(DistanceToWaypoint(999, 3.0, 60))
    assert data.target() is None
    data.listener(DistanceToWaypoint(1, 3.0, 60))
    data.listener(Finished("duration"))
    assert data.target() is None


def test_what_is_followed_is_the_target() -> None:
    """The place of the reference now, between two events too; it stands while the recording waits."""
    route, _ = made_following()
    assert route.reference is not None
    data = MapData(route)
    assert data.target() is None
    data.listener(Following(100.0, 24.0, 110.0, 0.2, waiting=False))
    data.listener(vehicle_at(0, 0, 100.5, mode="GUIDED"))
    target = data.target()
    assert target is not None
    expected_m = route.reference.state(24.5).position_m[:2]
    assert (target.north_m, target.east_m) == pytest.approx(tuple(expected_m), abs=0.2)
    assert target.label == ""
    data.listener(Following(101.0, 25.0, 110.0, 0.2, waiting=True))
    data.listener(vehicle_at(0, 0, 102.0, mode="GUIDED"))
    target = data.target()
    assert target is not None
    expected_m = route.reference.state(25.0).position_m[:2]
    assert (target.north_m, target.east_m) == pytest.approx(tuple(expected_m), abs=0.2)
    data.listener(PhaseStarted(Phase.RETURN))
    assert data.target() is None


def test_a_recording_that_is_followed_has_errors_from_its_first_fix_on() -> None:
    """Not on the run-up, which was not recorded."""
    data = MapData(made_following()[0])
    data.listener(Following(100.0, -3.0, 110.0, 0.2, waiting=False))
    data.listener(vehicle_at(0, 0, 101.0, mode="GUIDED"))
    data.listener(Following(104.0, 1.0, 110.0, 0.2, waiting=False))
    data.listener(vehicle_at(0, 0, 104.0, mode="GUIDED"))
    before, after = data.points(0)
    assert math.isnan(before.path_error_m)
    assert after.elapsed_s == pytest.approx(1.0)
    assert math.isfinite(after.path_error_m)

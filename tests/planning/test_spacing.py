"""The 3 m rule of DroneKit's example, and the route that it gives."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from flight_replay.geometry.geodesy import LocalFrame, distance_m
from flight_replay.logs.track import Track, track_from_columns
from flight_replay.mission.items import Command, MissionItem, speed_from_the_start
from flight_replay.planning.spacing import decimate, spaced_route
from tests.helpers.made_tracks import FRAME, straight_track


def track_of(north_east_m: NDArray[np.float64], lat_deg: float = 47.0, lon_deg: float = 8.0) -> Track:
    """A track through points given in metres, one fix a second."""
    lat, lon = LocalFrame(lat_deg, lon_deg).to_degrees(north_east_m)
    return track_from_columns(np.arange(len(lat), dtype=float), lat, lon, np.zeros(len(lat)))


def line(steps_m: list[float]) -> NDArray[np.float64]:
    """Points eastwards, so far apart."""
    return np.column_stack([np.zeros(len(steps_m) + 1), np.concatenate([[0], np.cumsum(steps_m)])])


@pytest.mark.parametrize(
    ("steps_m", "kept"),
    [
        ([], [0]),
        ([1.0], [0, 1]),
        ([0.0], [0, 1]),
        ([0.5] * 10, [0, 7, 10]),
        ([3.1, 3.1], [0, 1, 2]),
        ([2.9, 0.05, 0.1], [0, 3]),
        ([0.0] * 50, [0, 50]),
    ],
    ids=["one fix", "two fixes", "two equal fixes", "half metres", "just beyond", "on the edge", "hovering"],
)
def test_keeps_first_spaced_and_last(steps_m: list[float], kept: list[int]) -> None:
    """The first fix, every one more than 3 m from the last kept, and the last are kept."""
    assert decimate(track_of(line(steps_m))).tolist() == kept


def test_stops_at_the_most_points() -> None:
    """With the budget used up, the rest of the log is left."""
    assert decimate(track_of(line([4.0] * 300)), max_points=100).tolist() == list(range(100))


def test_recorded_heights_count_in_space() -> None:
    """A climb on the spot is kept, where it is to be flown."""
    up_m = np.array([10.0, 12.0, 14.0, 14.5, 20.0, 20.0])
    track = replace(track_of(line([0.0] * 5)), alt_m=up_m)
    assert decimate(track).tolist() == [0, 5]
    recorded = spaced_route(track, altitude_m="recorded").mission
    assert [item.alt_m for _, item in recorded.waypoints] == [10.0, 14.0, 20.0, 20.0]
    assert len(spaced_route(track).mission.waypoints) == 2


@pytest.mark.parametrize(
    ("lat_deg", "lon_deg"), [(0.0, 0.0), (60.0, 10.0), (-85.0, 179.99999), (70.0, -180.0)]
)
def test_metres_are_ground_metres_anywhere(lat_deg: float, lon_deg: float) -> None:
    """2.99 m east is not 3 m, 3.01 m is, at any latitude and across the antimeridian."""
    assert decimate(track_of(line([2.99, 4.0]), lat_deg, lon_deg)).tolist() == [0, 2]
    assert decimate(track_of(line([3.01, 4.0]), lat_deg, lon_deg)).tolist() == [0, 1, 2]


@given(
    st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=1, max_size=300),
    st.floats(0.5, 12),
    st.integers(1, 40),
)
def test_rule_holds_for_any_track(
    steps: list[tuple[float, float]], spacing_m: float, max_points: int
) -> None:
    """Order kept, budget kept, first fix kept, and no fix skipped that was far enough."""
    track = track_of(np.cumsum(np.array(steps), axis=0))
    kept = decimate(track, spacing_m, max_points)
    assert kept[0] == 0
    assert len(kept) <= max_points
    assert (np.diff(kept) > 0).all()
    for start, end in pairwise(kept):
        lat, lon = track.lat_deg[start:end], track.lon_deg[start:end]
        between = distance_m(lat[:1], lon[:1], lat[1:], lon[1:])
        assert (between <= spacing_m).all()


def test_waypoints_lie_on_kept_fixes_30_m_up() -> None:
    """Whatever altitude was recorded, the example flies 30 m above home."""
    route = spaced_route(straight_track(altitudes_m=3.0))
    assert len(route.mission.items) == 51
    assert {item.alt_m for item in route.mission.items} == {30.0}
    assert route.planned_error.recorded_to_path.error.max() < 1e-3
    assert len(route.covered) == 51


def test_a_full_budget_covers_only_what_it_reaches() -> None:
    """With the budget used up, the error is measured over the fixes up to the last waypoint."""
    route = spaced_route(straight_track(), max_points=10)
    assert len(route.covered) == 10
    assert route.path.length_m == pytest.approx(36.0, abs=1e-3)
    assert len(spaced_route(straight_track(fixes=150)).covered) == 100


def test_recorded_altitudes_are_flown_but_not_too_low() -> None:
    """Altitudes as recorded, but none below 5 m."""
    recorded_m = [-1.0, 2.0, *np.linspace(6, 20, 49)]
    route = spaced_route(straight_track(altitudes_m=recorded_m), altitude_m="recorded")
    flown_m = [item.alt_m for item in route.mission.items]
    assert flown_m[:2] == [5.0, 5.0]
    assert flown_m[2:] == pytest.approx(recorded_m[2:])


def test_a_given_speed_is_asked_for_once_after_a_second_here() -> None:
    """Then it holds for the whole route, also on a vehicle that would undo the first item of a mission."""
    items = spaced_route(straight_track(), speed_m_s=7.0).mission.items
    assert items[:2] == speed_from_the_start(7.0)
    assert [item.command for item in items].count(Command.CHANGE_SPEED) == 1


def test_recorded_heights_are_kept_at_recorded_speeds_too() -> None:
    """A hill flown over at 10 m/s up and down: the vehicle climbs to its top, later than the recorded one."""
    recorded_m = [10.0] * 10 + [*np.linspace(20, 60, 5), *np.linspace(50, 10, 5)] + [10.0] * 31
    track = straight_track(altitudes_m=recorded_m)
    route = spaced_route(track, spacing_m=0.5, altitude_m="recorded", speed_m_s="recorded")
    assert [item.alt_m for _, item in route.mission.waypoints] == recorded_m


def test_recorded_speeds_change_only_where_the_flight_did() -> None:
    """A flight at 4 m/s, then at 8 m/s, needs two speed changes."""
    slow, fast = straight_track(4.0, 30), straight_track(8.0, 60)
    north_m = np.concatenate([np.arange(30) * 4.0, 116 + np.arange(1, 31) * 8.0])
    lat, lon = FRAME.to_degrees(np.column_stack([north_m, np.zeros(60)]))
    assert len(slow) + 30 == len(fast)
    both = track_from_columns(np.arange(60.0), lat, lon, np.zeros(60))
    items = spaced_route(both, speed_m_s="recorded").mission.items
    assert [item.params[1] for item in items if item.command == Command.CHANGE_SPEED] == [
        pytest.approx(4.0, abs=0.01),
        pytest.approx(8.0, abs=0.01),
    ]


def at_speeds(speeds_m_s: list[float]) -> Track:
    """Legs of 10 m, each as fast as asked for."""
    north_m = 10.0 * np.arange(len(speeds_m_s) + 1)
    lat, lon = FRAME.to_degrees(np.column_stack([north_m, np.zeros(len(north_m))]))
    time_s = np.append(0.0, np.cumsum(10.0 / np.array(speeds_m_s)))
    return track_from_columns(time_s, lat, lon, np.zeros(len(lat)))


def speed_changes(items: tuple[MissionItem, ...]) -> dict[int, float]:
    """The speeds asked for, by the number of waypoints before them."""
    found, waypoints = {}, 0
    for item in items:
        waypoints += item.is_waypoint
        if item.command == Command.CHANGE_SPEED:
            found[waypoints] = item.params[1]
    return found


def test_a_speed_changes_where_it_differs_by_a_quarter() -> None:
    """A leg up to 1.25 times as fast or slow as the speed in force asks for no change."""
    track = at_speeds([4.0, 4.9, 3.3, 5.1, 6.2, 3.9])
    route = spaced_route(track, spacing_m=9.0, speed_m_s="recorded")
    assert speed_changes(route.mission.items) == pytest.approx({1: 4.0, 4: 5.1, 6: 3.9}, abs=0.01)


def test_speeds_are_asked_for_in_centimetres_a_second() -> None:
    """Two decimals are more than a vehicle keeps to."""
    (speed,) = speed_changes(spaced_route(at_speeds([3.33333]), speed_m_s="recorded").mission.items).values()
    assert speed == 3.33


@pytest.mark.parametrize(("recorded_m_s", "asked_m_s"), [(0.1, 0.5), (0.6, 0.6), (29.0, 29.0), (90.0, 30.0)])
def test_speeds_stay_within_what_copters_take(recorded_m_s: float, asked_m_s: float) -> None:
    """From 0.5 to 30 m/s, however slow or fast the recording."""
    items = spaced_route(at_speeds([recorded_m_s]), speed_m_s="recorded").mission.items
    assert speed_changes(items) == pytest.approx({1: asked_m_s}, abs=0.01)


def test_where_the_clock_stands_still_the_fastest_speed_is_asked_for() -> None:
    """A leg without duration has no speed of its own."""
    track = track_from_columns(
        np.zeros(2), *FRAME.to_degrees(np.array([[0.0, 0.0], [20.0, 0.0]])), np.zeros(2)
    )
    assert speed_changes(spaced_route(track, speed_m_s="recorded").mission.items) == {1: 30.0}


def test_home_is_below_the_first_fix() -> None:
    """The vehicle takes off where the recording begins."""
    track = straight_track()
    home = spaced_route(track).mission.home
    assert home is not None
    assert (home.lat_deg, home.lon_deg) == (track.lat_deg[0], track.lon_deg[0])


def test_a_long_hover_is_searched_to_its_end() -> None:
    """A thousand fixes at one place, then one 5 m away, which is kept at any budget."""
    places = np.zeros((1001, 2))
    places[-1] = [5.0, 0.0]
    for max_points in (2, 3, 100):
        assert decimate(track_of(places), max_points=max_points).tolist() == [0, 1000]
    places[500] = [0.0, 3.1]
    assert decimate(track_of(places)).tolist() == [0, 500, 501, 1000]

"""headings.py: a route is turned as the recorded vehicle was."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.track import track_from_columns
from flight_replay.mission.items import Command, MissionItem, change_speed
from flight_replay.planning.heading import headings, with_recorded_headings
from flight_replay.planning.prediction import with_prediction
from flight_replay.planning.route import Route
from flight_replay.planning.spacing import spaced_route
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.made_tracks import FRAME, straight_track


def route_with(heading_deg: float | list[float], *, spacing_m: float = 30.0) -> Route:
    """A flight north at 4 m/s, 50 s long, whose nose points elsewhere."""
    track = straight_track()
    column = np.broadcast_to(np.asarray(heading_deg, float), len(track)).copy()
    return spaced_route(replace(track, heading_deg=column), spacing_m=spacing_m, speed_m_s=4.0)


def error_deg(route: Route, takeoff_m: float = 30.0) -> float:
    predicted = with_prediction(route, takeoff_m).predicted
    assert predicted is not None
    statistics = predicted.heading_deg.statistics
    assert statistics is not None
    return statistics.mean


@pytest.mark.parametrize("timed", [True, False])
def test_the_vehicle_is_turned_as_recorded(timed: bool) -> None:
    """A flight sideways has a heading item on its legs, and flies sideways."""
    route = route_with(90.0)
    turned = with_recorded_headings(route, 30.0, timed=timed)
    assert error_deg(route) > 60
    assert error_deg(turned) < 12
    assert len(turned.mission.waypoints) == len(route.mission.waypoints)
    assert [int(seq) for seq in np.unique(turned.path.seq)] == [seq for seq, _ in turned.mission.waypoints]
    assert "turn the vehicle as recorded" in turned.notes[0]
    assert ("at equal places, not at equal times" in turned.notes[0]) != timed


def test_legs_that_are_flown_as_recorded_have_no_item() -> None:
    """A vehicle that looked ahead needs none, but to look ahead on the way to the first waypoint."""
    turned = with_recorded_headings(route_with(0.0), 30.0, timed=True)
    assert sum(item.command == Command.CONDITION_YAW for item in turned.mission.items) <= 1


@pytest.mark.parametrize(
    ("added", "words"),
    [(0, "No item that turns the vehicle"), (1, "1 item on top of the waypoints turns"), (2, "2 items on")],
)
def test_how_many_items_were_added_is_told(added: int, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """None at all, too."""
    route = route_with(0.0)
    more = (*route.mission.items, *[change_speed(4.0)] * added)
    mission = replace(route.mission, items=more)
    monkeypatch.setattr(headings, "_turned", lambda *_, **__: (mission, np.zeros(3)))
    assert words in with_recorded_headings(route, 30.0, timed=True).notes[-1]


def test_headings_that_are_far_off_are_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here because there is no room for the items."""
    ahead = with_recorded_headings(route_with(0.0), 30.0, timed=True)
    assert not any("degrees off" in note for note in ahead.notes)
    route = route_with(90.0)
    monkeypatch.setattr(headings, "MEMORIES", (len(route.mission.items),))
    notes = with_recorded_headings(route, 30.0, timed=True).notes
    (told,) = [note for note in notes if "degrees off" in note]
    assert told == (
        "100 % of the headings are expected to be more than 30 degrees off, the worst 90 degrees; "
        "--mode guided follows them more closely."
    )


def test_a_mission_that_is_over_before_the_first_heading_says_nothing_of_them() -> None:
    """Of a recording whose only heading is its last fix's, flown twice as fast."""
    track = straight_track()
    headings_deg = np.append(np.full(len(track) - 1, np.nan), 90.0)
    route = spaced_route(replace(track, heading_deg=headings_deg), spacing_m=30.0, speed_m_s=8.0)
    assert not any("degrees off" in note for note in with_recorded_headings(route, 30.0, timed=True).notes)


def test_a_recording_without_times_is_not_to_be_followed() -> None:
    """Nothing follows what has none."""
    assert headings._off_note(np.array([90.0, 0.0]), can_follow=False) == (
        "50 % of the headings are expected to be more than 30 degrees off, the worst 90 degrees."
    )


def test_a_log_without_heading_is_flown_the_vehicles_way() -> None:
    """A note says so."""
    route = route_with(np.nan)
    turned = with_recorded_headings(route, 30.0, timed=True)
    assert turned.mission is route.mission
    assert turned.notes == ("The log has no heading; the vehicle turns its own way.",)


def test_the_mission_stays_within_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """Items are left out where there is no room for them."""
    route = route_with(np.linspace(0.0, 1500.0, 51).tolist(), spacing_m=40.0)
    monkeypatch.setattr(headings, "MEMORIES", (len(route.mission.items) + 3,))
    turned = with_recorded_headings(route, 30.0, timed=True)
    assert len(turned.mission.items) <= len(route.mission.items) + 3


def test_speeds_stay_as_they_are() -> None:
    """A recording that changes its speed has the same changes, in the same order."""
    turned = with_recorded_headings(route_with(200.0), 30.0, timed=True)
    speeds = [item for item in turned.mission.items if item.command == Command.CHANGE_SPEED]
    assert speeds == [change_speed(4.0)]
    assert all(isinstance(item, MissionItem) for item in turned.mission.items)


def hovering(headings_deg: Floats) -> Route:
    """A flight 20 m north in 5 s, then a hover at its end: ``headings_deg`` (n,) are a second apart."""
    north_m = np.minimum(4.0 * np.arange(len(headings_deg)), 20.0)
    lat, lon = FRAME.to_degrees(np.column_stack([north_m, np.zeros_like(north_m)]))
    track = track_from_columns(np.arange(len(north_m), dtype=float), lat, lon, np.zeros_like(north_m))
    route = spaced_route(replace(track, heading_deg=headings_deg % 360.0), spacing_m=20.0, speed_m_s=4.0)
    *items, last = route.mission.items
    last = replace(last, params=(float(len(north_m) - 8), 0.0, 0.0, 0.0))
    return replace(route, mission=replace(route.mission, items=(*items, last)))


@pytest.mark.parametrize(
    "headings_deg",
    [
        pytest.param(45.0 * (np.arange(60) // 4), id="steps"),
        pytest.param(np.maximum(np.arange(100.0) - 8.0, 0.0) * 3.0, id="a slow pan"),
        pytest.param(np.maximum(np.arange(80.0) - 8.0, 0.0) * -10.0, id="two rounds"),
        pytest.param(60.0 * np.sin(np.arange(100.0) / 5.0), id="to and fro"),
    ],
)
def test_a_hover_turns_as_recorded(headings_deg: Floats) -> None:
    """All the time, with one waypoint: as many turns and waits as it needs follow one another."""
    route = hovering(headings_deg)
    turned = with_recorded_headings(route, 30.0, timed=True)
    assert error_deg(route) > 30
    assert error_deg(turned) < 5


def with_speed_changes(route: Route) -> Route:
    """The route with another speed on each of its legs."""
    speeds = (change_speed(4.0 + k % 2) for k in range(len(route.mission.waypoints)))
    items = [each for _, item in route.mission.waypoints for each in (next(speeds), item)]
    return replace(route, mission=replace(route.mission, items=tuple(items)))


def test_a_heading_lasts_over_changes_of_speed() -> None:
    """A flight sideways with a change of speed on each leg faces a far position: few items do."""
    route = with_speed_changes(route_with(90.0))
    turned = with_recorded_headings(route, 30.0, timed=True)
    added = len(turned.mission.items) - len(route.mission.items)
    assert sum(item.command == Command.SET_ROI for item in turned.mission.items) > 0
    assert error_deg(turned) < 5
    assert added < len(route.mission.waypoints)


def test_a_vehicle_with_a_gimbal_is_turned_without_positions_to_face() -> None:
    """They would turn its gimbal: it is turned on every leg instead, each time from the path's heading."""
    route = with_speed_changes(route_with(90.0))
    gimbal = replace(route, limits=VehicleLimits(Limits(mount_type=1.0)))
    turned = with_recorded_headings(gimbal, 30.0, timed=True)
    assert not any(item.command == Command.SET_ROI for item in turned.mission.items)
    assert error_deg(turned) < 30


def test_turns_are_planned_with_the_climb_from_the_takeoff() -> None:
    """After a climb to the first waypoint the first leg begins slowly, and all turns come later."""
    route = route_with((20.0 * np.arange(51)).tolist())
    turned = with_recorded_headings(route, 10.0, timed=True)
    assert error_deg(turned, takeoff_m=10.0) < 5
    assert error_deg(with_recorded_headings(route, 30.0, timed=True), takeoff_m=10.0) > 10

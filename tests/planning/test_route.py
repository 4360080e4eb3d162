"""The example's route, with its heights, speeds and planned error."""

import numpy as np
import pytest

from flight_replay.logs.track import track_from_columns
from flight_replay.mission.items import Command
from flight_replay.planning.altitude import MIN_ALTITUDE_M
from flight_replay.planning.spacing import spaced_route
from tests.helpers.made_tracks import FRAME, straight_track


def test_waypoints_lie_on_kept_fixes_30_m_up() -> None:
    """Whatever height was recorded, the example flies 30 m above home."""
    route = spaced_route(straight_track(heights_m=3.0))
    assert len(route.mission.items) == 51
    assert {item.alt_m for item in route.mission.items} == {30.0}
    assert route.planned_error.max < 1e-3
    assert len(route.covered) == 51


def test_a_full_budget_covers_only_what_it_reaches() -> None:
    """With the budget used up, the error is measured over the fixes up to the last waypoint."""
    route = spaced_route(straight_track(), max_points=10)
    assert len(route.covered) == 10
    assert route.path.length_m == pytest.approx(36.0, abs=1e-3)


def test_recorded_heights_never_lead_into_the_ground() -> None:
    """Heights as recorded, but not below the floor."""
    heights_m = [-1.0, 2.0, *np.linspace(6, 20, 49)]
    route = spaced_route(straight_track(heights_m=heights_m), altitude_m="recorded")
    flown_m = [item.alt_m for item in route.mission.items]
    assert flown_m[:2] == [MIN_ALTITUDE_M, MIN_ALTITUDE_M]
    assert flown_m[2:] == pytest.approx(heights_m[2:])


def test_a_given_speed_is_asked_for_once_and_first() -> None:
    """One DO_CHANGE_SPEED in front of the first waypoint sets it for all legs."""
    items = spaced_route(straight_track(), speed_m_s=7.0).mission.items
    assert [item.command for item in items].count(Command.CHANGE_SPEED) == 1
    assert items[0].params[:2] == (1.0, 7.0)


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


def test_a_hover_asks_for_no_impossible_speed() -> None:
    """Where the clock or the place stands still, the speed asked for stays within what copters take."""
    track = track_from_columns(np.zeros(3), *FRAME.to_degrees(np.zeros((3, 2))), np.zeros(3))
    for item in spaced_route(track, speed_m_s="recorded").mission.items:
        if item.command == Command.CHANGE_SPEED:
            assert 0.5 <= item.params[1] <= 30

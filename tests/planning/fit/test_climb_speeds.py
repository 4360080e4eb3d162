"""Legs that climb and descend at the recorded speed, not as fast as the vehicle can."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.mission.items import Command
from flight_replay.planning.fit.climb_speeds import leg_climbs_m_s
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.reference import AT_SEA_LEVEL
from flight_replay.planning.fit.simulated_draft import items_changed, items_of, simulate_draft
from flight_replay.planning.fit.speed_schedule import Schedule, slowest_m_s
from flight_replay.planning.fit.speed_search import SpeedSearch
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import FRAME

PLACES_M = np.array([(0, 0, 10), (0, 0.2, 30), (0, 3, 30), (0, 3, 10), (40, 3, 12), (40, 3, 8)], float)
NO_SPEEDS = np.full(6, np.nan)
COLUMNS = Draft(PLACES_M, np.array([False] * 6), np.array([2.0, 2, 2, 2, 2, 0]), NO_SPEEDS)
SPEEDS_M_S = np.array([np.nan, 0.8, 1.0, 0.9, 4.0, 3.0])


def test_steep_legs_climb_at_their_speed_and_the_next_as_the_vehicle_can() -> None:
    """Up to the vehicle's own speeds; a level leg asks for none, nor one that no slow climb came before."""
    climbs = leg_climbs_m_s(PLACES_M, SPEEDS_M_S, Limits())
    assert climbs == pytest.approx([np.nan, 0.8, np.nan, -0.9, 2.5, -1.5], nan_ok=True)
    assert np.isnan(leg_climbs_m_s(PLACES_M, NO_SPEEDS, Limits())).all()


def test_a_climb_speed_is_followed_by_the_ground_speed() -> None:
    """Firmware that knows no climb speeds takes them for ground speeds."""
    slow = replace(COLUMNS, speed_m_s=np.array([np.nan, 0.8, np.nan, np.nan, 4.0, np.nan]))
    items = slow.mission(FRAME, Limits()).items
    speeds = [(*item.params[:2],) for item in items if item.command == Command.CHANGE_SPEED]
    assert speeds == [(2, 0.8), (1, 0.8), (3, 0.8), (1, 0.8), (2, 2.5), (1, 4), (3, 1.5), (1, 4)]
    assert [item.ground_speed_m_s for item in items if not item.is_waypoint][:2] == [None, 0.8]


def test_level_drafts_and_those_at_the_vehicles_speed_ask_for_no_climb() -> None:
    """One speed from the start is that over the ground."""
    once = replace(COLUMNS, speed_m_s=np.array([1.0, *NO_SPEEDS[1:]]))
    for draft in (COLUMNS, once, replace(COLUMNS, places_m=PLACES_M * (1, 1, 0), speed_m_s=SPEEDS_M_S)):
        items = draft.mission(FRAME, Limits()).items
        assert all(item.params[0] == 1 for item in items if item.command == Command.CHANGE_SPEED)


def test_columns_are_climbed_in_the_recorded_time() -> None:
    """Places above each other are left on time, and the flight is that of the draft with its speeds."""
    leave_s = np.array([0.0, 28.0, 36.5, 64.0, 82.0, 92.0])
    found = SpeedSearch(Schedule(COLUMNS, leave_s), np.full(6, 8.0), Limits(), 0.05, AT_SEA_LEVEL).run()
    assert np.abs(found.passed_s - leave_s).max() < 0.11
    up_m = np.interp([13.0, 51.0], found.time_s, found.place_m[:, 2])
    assert up_m == pytest.approx([20.0, 20.0], abs=2.0)
    again = simulate_draft(found.draft, Limits(), 0.05)
    assert (found.place_m == again.place_m).all()
    assert slowest_m_s(COLUMNS)[1] < slowest_m_s(COLUMNS)[2]


def test_climbs_of_a_changed_draft_are_made_of_those_before() -> None:
    """A steep leg that is another by a change keeps its item, with another speed."""
    before = replace(COLUMNS, speed_m_s=SPEEDS_M_S)
    items, seqs = items_of(before, Limits(), every_speed=True)
    after = replace(before, speed_m_s=SPEEDS_M_S * 1.5)
    assert items_changed(items, seqs, before, after, Limits()) == items_of(after, Limits())[0]
    level = replace(before, places_m=PLACES_M + np.array([[0, 30.0 * i, 0] for i in range(6)]))
    changed = items_changed(items, seqs, before, level, Limits())
    assert [item.command for item in changed] == [item.command for item in items]

"""Home as stations move it; in vehicle time."""

from __future__ import annotations

import math

import pytest

from flight_replay.mavlink import dialect
from tests.helpers.sim_station import (
    ARM,
    AUTO,
    FAILED,
    GUIDED,
    READY_S,
    RTL,
    START,
    TAKEOFF,
    Station,
    item_at,
    sim,
)

SET_HOME = 179


def move_home(station: Station, north_m: float, amsl_m: float) -> int:
    """DO_SET_HOME at a location; returns a MAV_RESULT."""
    x, y = item_at(north_m, 0)[3:5]
    return station.command_int(SET_HOME, dialect.MAV_FRAME_GLOBAL, [0, 0, 0, 0], (x, y, amsl_m))


def test_home_can_be_moved() -> None:
    """DO_SET_HOME here, or at a location: RTL then lands there."""
    autopilot, station = sim()
    assert station.command(SET_HOME, 1) == 4
    station.fly()
    x, y = item_at(30, 0)[3:5]
    assert station.command_int(SET_HOME, 0, [0, 0, 0, 0], (x, y, 488.0)) == 0
    assert station.last("HOME_POSITION").latitude == x
    assert station.command_int(SET_HOME, 1, [0, 0, 0, 0], (x, y, 488.0)) == 2
    assert station.command(SET_HOME, 5, 0, 0, 0, 47.0, 8.0, 0) == 4
    station.mode(6)
    assert station.run(100, lambda: not autopilot.armed)
    assert math.dist(autopilot.flight.position_m, (30, 0, 0)) < 1.0
    assert station.command(SET_HOME, 1) == 0
    assert station.command(dialect.MAV_CMD_GET_HOME_POSITION) == 0


def test_home_stays_where_a_station_has_put_it() -> None:
    """Arming does not move it; altitudes of take-off and RTL count from its height, and RTL lands there."""
    autopilot, station = sim(RTL_ALT=3000)
    station.run(READY_S)
    assert move_home(station, 30.0, START.alt_amsl_m - 10) == 0
    station.mode(GUIDED)
    assert station.command(ARM, 1) == 0
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 5) == FAILED
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 20) == 0
    station.run(15)
    assert math.dist(autopilot.flight.position_m, (0, 0, 10)) < 0.5
    station.mode(RTL)
    assert station.run(60, lambda: autopilot.flight.position_m[0] > 10)
    assert autopilot.flight.position_m[2] == pytest.approx(20, abs=0.5)
    assert station.run(100, lambda: not autopilot.armed)
    assert math.dist(autopilot.flight.position_m, (30, 0, 0)) < 1.0


def test_a_mission_goes_on_when_home_is_moved() -> None:
    """Places stay; altitudes above home count from its new height for the legs that are not begun."""
    autopilot, station = sim()
    station.fly(10)
    station.upload([item_at(40, 0), item_at(40, 40), item_at(0, 40), item_at(0, 0)])
    station.mode(AUTO)
    assert station.run(60, lambda: 1 in station.reached())
    assert move_home(station, -30.0, START.alt_amsl_m - 1.5) == 0
    assert station.run(90, lambda: 4 in station.reached())
    station.run(5)
    assert math.dist(autopilot.flight.position_m, (0, 0, 18.5)) < 0.5


def test_a_target_is_flown_to_when_home_is_moved() -> None:
    """The copter does not stop."""
    autopilot, station = sim()
    station.fly()
    command, frame, params, x, y, z = item_at(100, 0)
    station.send(dialect.MAVLink_mission_item_int_message(1, 1, 0, frame, command, 2, 1, *params, x, y, z))
    station.run(5)
    assert move_home(station, -30.0, START.alt_amsl_m) == 0
    station.run(20)
    assert autopilot.flight.position_m[0] == pytest.approx(100, abs=1)


def test_a_return_goes_on_to_where_home_was() -> None:
    """Its way is planned when it begins; the next one goes to the new home."""
    autopilot, station = sim()
    station.fly()
    station.mode(RTL)
    station.run(2)
    assert move_home(station, 30.0, START.alt_amsl_m) == 0
    assert station.run(100, lambda: not autopilot.armed)
    assert math.dist(autopilot.flight.position_m, (0, 0, 0)) < 1.0

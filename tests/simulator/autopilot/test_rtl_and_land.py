"""RTL, LAND and home; in vehicle time."""

from __future__ import annotations

import math

import pytest

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.flight.guided import GuidedTarget
from tests.helpers.sim_station import (
    ACCEPTED,
    AUTO,
    LAND,
    RTL,
    act,
    item_at,
    sim,
    takeoff,
)


def test_rtl_climbs_returns_waits_and_lands() -> None:
    """From below RTL_ALT the copter climbs to it first, then flies home, lands and disarms there."""
    autopilot, station = sim(RTL_ALT=2500)
    station.fly(10)
    autopilot.flight.follow(GuidedTarget(position_m=(40.0, 0.0, 10.0)))
    station.run(20)
    assert station.command(dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH) == ACCEPTED
    highest = 0.0
    while autopilot.armed:
        station.run(1)
        highest = max(highest, autopilot.above_home_m)
        assert autopilot.time_s < 200
    assert highest == pytest.approx(25, abs=0.5)
    assert math.dist(autopilot.flight.position_m, (0, 0, 0)) < 0.5
    assert autopilot.mode == CopterMode.RTL


def test_land_comes_down_here() -> None:
    """LAND descends where it is and disarms."""
    autopilot, station = sim()
    station.fly(15)
    autopilot.flight.follow(GuidedTarget(position_m=(30.0, 10.0, 15.0)))
    station.run(20)
    assert station.command(dialect.MAV_CMD_NAV_LAND) == ACCEPTED
    assert station.run(60, lambda: not autopilot.armed)
    assert math.dist(autopilot.flight.position_m, (30, 10, 0)) < 1


def test_home_is_where_it_was_armed() -> None:
    """After landing elsewhere, arming moves home there: heights and RTL count from it."""
    autopilot, station = sim()
    station.fly(10)
    autopilot.flight.follow(GuidedTarget(position_m=(50.0, 20.0, 10.0)))
    station.run(20)
    station.mode(LAND)
    station.run(60, lambda: not autopilot.armed)
    station.fly(10)
    assert autopilot.home is not None
    assert math.dist(autopilot.home.position_m, (50, 20, 0)) < 1
    autopilot.flight.follow(GuidedTarget(position_m=(80.0, 20.0, 10.0)))
    station.run(15)
    station.mode(RTL)
    assert station.run(100, lambda: not autopilot.armed)
    assert math.dist(autopilot.flight.position_m, (50, 20, 0)) < 1


@pytest.mark.parametrize(
    "start", [Start(-89.0, 179.9999, 10, 0), Start(64.1, -180.0, 0, 0), Start(0, 0.0, 5, 0)]
)
def test_it_flies_anywhere_on_earth(start: Start) -> None:
    """Near a pole, on the antimeridian and at zero degrees, a mission comes out where it should."""
    autopilot, station = sim(start=start)
    station.fly(10)
    there = start.location_of((60.0, 60.0, 0.0))
    station.upload([(16, 3, (0.0, 0.0, 0.0, 0.0), there.lat_e7, there.lon_e7, 10.0)])
    station.mode(AUTO)
    assert station.run(60, lambda: station.reached() == [1])
    assert math.dist(autopilot.flight.position_m, (60, 60, 10)) < 2.5


def test_the_landed_state_follows_the_flight() -> None:
    """EXTENDED_SYS_STATE goes from ground over take-off, air and landing to ground, in every way down."""
    mission = [takeoff(10), item_at(5, 0, 10), act(20)]
    for way in (RTL, LAND, AUTO):
        autopilot, station = sim()
        station.command(511, dialect.MAVLINK_MSG_ID_EXTENDED_SYS_STATE, 200000)
        station.fly(10)
        station.run(3)
        station.upload(mission)
        station.mode(way)
        assert station.run(120, lambda: not autopilot.armed)  # noqa: B023
        station.run(1)
        states = [message.landed_state for message in station.of("EXTENDED_SYS_STATE")]
        changes = [
            state for state, before in zip(states, [None, *states[:-1]], strict=True) if state != before
        ]
        assert changes == [1, 3, 2, 4, 1] if way != AUTO else changes[-3:] == [2, 4, 1]

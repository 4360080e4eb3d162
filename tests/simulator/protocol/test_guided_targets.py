"""GUIDED: positions, velocities, speeds and headings that stations send."""

from __future__ import annotations

import math

import pytest

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from tests.helpers.sim_station import AUTO, GUIDED, LOITER, START, Station, item_at, sim

POSITION_ONLY, VELOCITY_ONLY = 0b0000110111111000, 0b0000110111000111
LOCAL, OFFSET, BODY = 1, 7, 9
REPOSITION, CHANGE_SPEED, CONDITION_YAW = 192, 178, 115


def item(station: Station, current: int, north_m: float, up_m: float, command: int = 16) -> int:
    """A MISSION_ITEM with the given ``current``, as DroneKit's simple_goto sends it."""
    there = START.location_of((north_m, 0.0, 0.0))
    station.send(
        dialect.MAVLink_mission_item_message(
            1, 1, 0, 3, command, current, 0, 0, 0, 0, 0, there.lat_e7 / 1e7, there.lon_e7 / 1e7, up_m
        )
    )
    return int(station.last("MISSION_ACK").type)


def local(
    station: Station, mask: int, frame: int, where: tuple[float, ...], velocity: tuple[float, ...]
) -> None:
    """SET_POSITION_TARGET_LOCAL_NED."""
    station.send(
        dialect.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, frame, mask, *where, *velocity, 0, 0, 0, 0, 0
        )
    )


NOWHERE = (0.0, 0.0, 0.0)


def test_an_item_with_current_2_is_flown_to() -> None:
    """DroneKit's simple_goto works in GUIDED only, and only with waypoints."""
    autopilot, station = sim()
    station.fly()
    assert item(station, 2, 30.0, 25.0) == dialect.MAV_MISSION_ACCEPTED
    station.run(25)
    assert math.dist(autopilot.flight.position_m, (30, 0, 25)) < 1.0
    assert item(station, 2, 30.0, 25.0, command=82) == dialect.MAV_MISSION_ERROR
    assert item(station, 2, 30.0, 25.0, command=2999) == dialect.MAV_MISSION_UNSUPPORTED
    station.mode(LOITER)
    assert item(station, 2, 60.0, 25.0) == dialect.MAV_MISSION_ERROR


def test_an_item_with_current_3_changes_nothing() -> None:
    """ArduCopter accepts a change of altitude, and stays."""
    autopilot, station = sim()
    station.fly()
    assert item(station, 3, 500.0, 30.0) == dialect.MAV_MISSION_ACCEPTED
    station.run(15)
    assert math.dist(autopilot.flight.position_m, (0, 0, 20)) < 1.0


def test_nothing_leaves_the_ground_by_a_target() -> None:
    """On the ground, even armed, positions and velocities move nothing."""
    autopilot, station = sim()
    station.run(10)
    station.mode(GUIDED)
    station.command(400, 1)
    assert item(station, 2, 30.0, 25.0) == dialect.MAV_MISSION_ACCEPTED
    local(station, VELOCITY_ONLY, LOCAL, NOWHERE, (5.0, 0.0, -1.0))
    station.run(5)
    assert autopilot.flight.position_m == (0, 0, 0)


@pytest.mark.parametrize(
    ("frame", "where", "end"),
    [
        (LOCAL, (20.0, 10.0, -25.0), (20, 10, 25)),
        (OFFSET, (20.0, 10.0, -5.0), (20, 10, 25)),
        (BODY, (20.0, 10.0, -5.0), (-10, 20, 25)),
    ],
)
def test_local_positions_are_flown_to(frame: int, where: tuple[float, ...], end: tuple[float, ...]) -> None:
    """From the origin, from here, and ahead of the nose, which looks east at the start."""
    autopilot, station = sim()
    station.fly()
    station.run(5)
    local(station, POSITION_ONLY, frame, where, NOWHERE)
    station.run(25)
    assert math.dist(autopilot.flight.position_m, end) < 1.0
    station.channel.request(dialect.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED)
    target = station.last("POSITION_TARGET_LOCAL_NED")
    assert math.dist((target.x, target.y, -target.z), end) < 1.0


def test_a_velocity_is_flown_until_it_is_not_repeated() -> None:
    """GUID_TIMEOUT seconds after the last message the copter stops."""
    autopilot, station = sim()
    station.fly()
    for _ in range(6):
        local(station, VELOCITY_ONLY, LOCAL, NOWHERE, (3.0, 0.0, -1.0))
        station.run(1)
    assert autopilot.flight.velocity_m_s == pytest.approx((3, 0, 1), abs=0.2)
    station.run(10)
    assert autopilot.flight.velocity_m_s == pytest.approx((0, 0, 0), abs=0.1)


@pytest.mark.parametrize(
    ("mask", "frame", "velocity"),
    [
        (VELOCITY_ONLY, LOCAL, (2000.0, 0.0, 0.0)),
        (VELOCITY_ONLY, LOCAL, (math.nan, 0.0, 0.0)),
        (VELOCITY_ONLY, 4, (3.0, 0.0, 0.0)),
        (0b0000111111111111, LOCAL, (3.0, 0.0, 0.0)),
    ],
)
def test_what_makes_no_sense_stops_the_copter(mask: int, frame: int, velocity: tuple[float, ...]) -> None:
    """Implausible velocities, foreign frames and empty masks are a stop."""
    autopilot, station = sim()
    station.fly()
    local(station, VELOCITY_ONLY, LOCAL, NOWHERE, (3.0, 0.0, 0.0))
    station.run(2)
    local(station, mask, frame, NOWHERE, velocity)
    station.run(6)
    assert autopilot.flight.velocity_m_s == pytest.approx((0, 0, 0), abs=0.1)


def test_global_targets_are_flown_to() -> None:
    """SET_POSITION_TARGET_GLOBAL_INT with a location, a velocity, and an invalid location."""
    autopilot, station = sim()
    station.fly()
    there = START.location_of((25.0, 0.0, 0.0))

    def target(mask: int, frame: int, lat_e7: int, velocity: tuple[float, ...]) -> None:
        station.send(
            dialect.MAVLink_set_position_target_global_int_message(
                0, 1, 1, frame, mask, lat_e7, there.lon_e7, 22.0, *velocity, 0, 0, 0, 0, 0
            )
        )

    target(POSITION_ONLY, 6, there.lat_e7, NOWHERE)
    station.run(20)
    assert math.dist(autopilot.flight.position_m, (25, 0, 22)) < 1.0
    target(VELOCITY_ONLY, 6, 0, (0.0, 2.0, 0.0))
    station.run(2)
    assert autopilot.flight.velocity_m_s[1] > 1.5
    target(POSITION_ONLY, 6, 910000000, NOWHERE)
    station.run(5)
    assert autopilot.flight.velocity_m_s == pytest.approx((0, 0, 0), abs=0.1)
    station.mode(LOITER)
    target(POSITION_ONLY, 6, there.lat_e7 + 5000, NOWHERE)
    local(station, VELOCITY_ONLY, LOCAL, NOWHERE, (3.0, 0.0, 0.0))
    station.run(3)
    assert autopilot.flight.velocity_m_s == pytest.approx((0, 0, 0), abs=0.1)


def test_reposition_flies_there_and_may_enter_guided() -> None:
    """DO_REPOSITION needs GUIDED or the flag that changes to it, and a valid location."""
    autopilot, station = sim()
    station.fly()
    x, y = item_at(20, 0)[3:5]
    station.mode(LOITER)
    assert station.command_int(REPOSITION, 6, [-1, 0, 0, 0], (x, y, 20.0)) == 2
    assert station.command_int(REPOSITION, 6, [-1, 1, 0, 0], (950000000, y, 20.0)) == 2
    assert station.command_int(REPOSITION, 6, [-1, 1, 0, 0], (x, y, 20.0)) == 0
    assert autopilot.mode == CopterMode.GUIDED
    station.run(20)
    assert math.dist(autopilot.flight.position_m, (20, 0, 20)) < 1.0


def test_speeds_change_in_guided() -> None:
    """DO_CHANGE_SPEED holds for the present target; without a speed, or on the ground, it fails."""
    autopilot, station = sim()
    assert station.command(CHANGE_SPEED, 1, 5) == 4
    station.fly()
    item(station, 2, 200.0, 20.0)
    assert station.command(CHANGE_SPEED, 1, 3) == 0
    station.run(10)
    assert autopilot.flight.velocity_m_s[0] == pytest.approx(3, abs=0.2)
    assert station.command(CHANGE_SPEED, 1, 0) == 4


def test_a_descent_speed_resets_the_climb_speed_in_guided() -> None:
    """Each of the two is set beside the other one's parameter."""
    autopilot, station = sim()
    station.fly()
    assert station.command(CHANGE_SPEED, 2, 1) == 0
    assert station.command(CHANGE_SPEED, 3, 1) == 0
    item(station, 2, 0.0, 100.0)
    station.run(10)
    assert autopilot.flight.velocity_m_s[2] == pytest.approx(2.5, abs=0.1)


def test_speeds_change_in_rtl() -> None:
    """DO_CHANGE_SPEED governs the return that is flown."""
    autopilot, station = sim()
    station.fly()
    item(station, 2, 200.0, 20.0)
    station.run(40)
    station.mode(6)
    station.run(10)
    assert station.command(CHANGE_SPEED, 1, 3) == 0
    station.run(5)
    assert autopilot.flight.velocity_m_s[0] == pytest.approx(-3, abs=0.2)


def test_speeds_change_in_auto_by_command_and_by_parameter() -> None:
    """Both DO_CHANGE_SPEED and WPNAV_SPEED govern the leg that is flown, at once."""
    autopilot, station = sim()
    station.fly()
    station.upload([item_at(1000, 0)])
    station.mode(3)
    station.run(20)
    assert autopilot.flight.velocity_m_s[0] == pytest.approx(10, abs=0.3)
    assert station.command(CHANGE_SPEED, 1, 4) == 0
    station.run(10)
    assert autopilot.flight.velocity_m_s[0] == pytest.approx(4, abs=0.3)
    autopilot.parameters.assign("WPNAV_SPEED", 700)
    station.run(10)
    assert autopilot.flight.velocity_m_s[0] == pytest.approx(7, abs=0.3)


def test_the_heading_can_be_set() -> None:
    """CONDITION_YAW turns to an angle, or by one; a bad angle fails."""
    autopilot, station = sim()
    station.fly()
    assert station.command(CONDITION_YAW, 180, 0, 0, 0) == 0
    station.run(8)
    assert abs(math.degrees(autopilot.flight.attitude_rad[2])) == pytest.approx(180, abs=3)
    assert station.command(CONDITION_YAW, 30, 0, -1, 1) == 0
    station.run(8)
    assert math.degrees(autopilot.flight.attitude_rad[2]) == pytest.approx(150, abs=3)
    assert station.command(CONDITION_YAW, 400) == 4


@pytest.mark.parametrize("command", [dialect.MAV_CMD_DO_SET_ROI, dialect.MAV_CMD_DO_SET_ROI_LOCATION])
def test_a_region_of_interest_is_faced(command: int) -> None:
    """The nose points there, wherever the copter flies to; DO_SET_ROI_NONE ends that."""
    autopilot, station = sim()
    station.fly()
    station.upload([item_at(30, 30), item_at(-200, 30)])
    x, y = item_at(30, 0)[3:5]
    assert station.command_int(command, 3, [0, 0, 0, 0], (x, y, 0.0)) == 0
    station.run(5)
    assert math.degrees(autopilot.flight.attitude_rad[2]) == pytest.approx(0, abs=2)
    station.mode(AUTO)
    station.run(1)
    assert station.command_int(command, 3, [0, 0, 0, 0], (x, y, 0.0)) == 0
    assert station.run(60, lambda: 1 in station.reached())
    assert math.degrees(autopilot.flight.attitude_rad[2]) == pytest.approx(-90, abs=6)
    assert station.command_int(command, 1, [0, 0, 0, 0], (x, y, 5.0)) == 2
    assert station.command(dialect.MAV_CMD_DO_SET_ROI_NONE) == 0
    station.run(6)
    assert abs(math.degrees(autopilot.flight.attitude_rad[2])) == pytest.approx(180, abs=6)

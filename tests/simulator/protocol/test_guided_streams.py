"""GUIDED: streams of targets, what each mask chooses, and what is dropped."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import pytest

from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.faults import COPTER_3_3, Faults
from tests.helpers.sim_station import GUIDED, LOITER, START, Station, sim

NO_POSITION, NO_VELOCITY, NO_ACCELERATION = 0b111, 0b111 << 3, 0b111 << 6
FORCE, NO_YAW, NO_RATE = 1 << 9, 1 << 10, 1 << 11
NO_TURN = NO_YAW | NO_RATE
LOCAL, BODY, RELATIVE, TERRAIN = 1, 9, 6, 11
CONDITION_YAW = 115
ZERO = (0.0, 0.0, 0.0)


class Motion(NamedTuple):
    """A target, north, east and up."""

    position: tuple[float, float, float] = (0.0, 0.0, 20.0)
    velocity: tuple[float, float, float] = ZERO
    acceleration: tuple[float, float, float] = ZERO
    yaw: float = 0.0
    yaw_rate: float = 0.0

    @property
    def ned(self) -> list[float]:
        """Its numbers as messages have them."""
        groups = self.position, self.velocity, self.acceleration
        return [value for n, e, u in groups for value in (n, e, -u)] + [self.yaw, self.yaw_rate]


def local(station: Station, mask: int, motion: Motion, frame: int = LOCAL) -> None:
    """SET_POSITION_TARGET_LOCAL_NED."""
    station.send(dialect.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, mask, *motion.ned))


def world(station: Station, mask: int, motion: Motion, frame: int = RELATIVE) -> None:
    """SET_POSITION_TARGET_GLOBAL_INT."""
    there = START.location_of(motion.position)
    station.send(
        dialect.MAVLink_set_position_target_global_int_message(
            0, 1, 1, frame, mask, there.lat_e7, there.lon_e7, motion.position[2], *motion.ned[3:]
        )
    )


def told(station: Station) -> dialect.MAVLink_position_target_local_ned_message:
    """The target that the copter says it has."""
    station.channel.request(dialect.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED)
    return station.last("POSITION_TARGET_LOCAL_NED")


ALL = Motion((3.0, 4.0, 22.0), (1.0, 2.0, 0.5), (0.3, 0.4, 0.1))


@pytest.mark.parametrize(
    ("mask", "answered"),
    [
        (0, NO_TURN),
        (NO_ACCELERATION, NO_TURN),
        (1 << 8, NO_TURN),
        (NO_POSITION, NO_TURN | NO_POSITION),
        (1 | NO_ACCELERATION, NO_TURN | NO_POSITION),
        (NO_POSITION | 1 << 4, NO_TURN | NO_POSITION | NO_VELOCITY),
        (NO_VELOCITY | NO_ACCELERATION, NO_TURN | NO_VELOCITY | NO_ACCELERATION),
    ],
)
def test_what_is_ignored_chooses_the_controller(mask: int, answered: int) -> None:
    """One ignored axis ignores its group; with a velocity, acceleration is zero or as sent."""
    _autopilot, station = sim()
    station.fly()
    local(station, mask, ALL)
    target = told(station)
    assert target.type_mask == answered
    if not answered & NO_POSITION:
        assert (target.x, target.y, target.z) == pytest.approx((3.0, 4.0, -22.0))
    if not answered & NO_VELOCITY:
        assert (target.vx, target.vy, target.vz) == pytest.approx((1.0, 2.0, -0.5))
    if not mask & NO_ACCELERATION:
        assert (target.afx, target.afy, target.afz) == pytest.approx((0.3, 0.4, -0.1))
    else:
        assert (target.afx, target.afy, target.afz) == (0, 0, 0)


@pytest.mark.parametrize("mask", [NO_VELOCITY, NO_POSITION | NO_VELOCITY | NO_ACCELERATION])
def test_combinations_without_a_controller_stop_the_copter(mask: int) -> None:
    """A position with an acceleration, or nothing at all."""
    autopilot, station = sim()
    station.fly()
    local(station, NO_POSITION, Motion(velocity=(5.0, 0.0, 0.0)))
    station.run(2.0)
    local(station, mask, ALL)
    station.run(8.0)
    assert autopilot.flight.velocity_m_s == pytest.approx(ZERO, abs=0.1)


def test_a_global_target_with_position_and_velocity_loses_its_acceleration() -> None:
    """Alone, or with a velocity only, the acceleration counts; above terrain a velocity stops the copter."""
    _autopilot, station = sim()
    station.fly()
    world(station, 0, ALL)
    target = told(station)
    assert (target.vx, target.vy, target.vz) == pytest.approx((1.0, 2.0, -0.5))
    assert (target.afx, target.afy, target.afz) == (0, 0, 0)
    world(station, NO_POSITION, ALL)
    assert told(station).afx == pytest.approx(0.3)
    world(station, 0, ALL, TERRAIN)
    stopped = told(station)
    assert stopped.type_mask == NO_TURN | NO_POSITION
    assert (stopped.vx, stopped.afx) == (0, 0)
    world(station, NO_VELOCITY | NO_ACCELERATION, ALL, TERRAIN)
    assert told(station).type_mask == NO_TURN | NO_VELOCITY | NO_ACCELERATION


def test_accelerations_turn_with_the_body() -> None:
    """Looking east, forward is east; positions are from here."""
    _autopilot, station = sim()
    station.fly()
    local(station, NO_TURN, Motion((10.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, 0.0, 0.0)), BODY)
    target = told(station)
    assert (target.x, target.y) == pytest.approx((0.0, 10.0), abs=0.1)
    assert (target.vx, target.vy, target.afx, target.afy) == pytest.approx((0, 1, 0, 0.5), abs=0.02)


def test_force_is_not_taken_for_acceleration() -> None:
    """With the force bit the whole target is dropped, unless its acceleration is ignored."""
    _autopilot, station = sim()
    station.fly()
    before = told(station).type_mask
    local(station, FORCE, ALL)
    assert told(station).type_mask == before
    local(station, FORCE | NO_ACCELERATION, ALL)
    assert told(station).type_mask == NO_TURN


def test_a_stream_that_ends_is_held_after_guid_timeout() -> None:
    """It goes on with the last velocity for GUID_TIMEOUT, then returns to where the target ended."""
    autopilot, station = sim()
    autopilot.parameters.assign("GUID_TIMEOUT", 1.0)
    station.fly()
    for tenth in range(50):
        local(station, NO_TURN, Motion((0.3 * tenth, 0.0, 20.0), (3.0, 0.0, 0.0)))
        station.run(0.1)
    station.run(20.0)
    assert autopilot.flight.velocity_m_s == pytest.approx(ZERO, abs=0.05)
    assert autopilot.flight.position_m[0] == pytest.approx(14.7 + 3.0, abs=0.2)


def test_headings_are_turned_to_and_others_taken_over() -> None:
    """A target's heading holds; CONDITION_YAW holds until the next target; without one the nose leads."""
    autopilot, station = sim()
    station.fly()

    def heading() -> float:
        return math.degrees(autopilot.flight.attitude_rad[2])

    local(station, NO_ACCELERATION | NO_RATE, Motion(yaw=-1.0))
    station.run(5.0)
    assert heading() == pytest.approx(math.degrees(-1.0), abs=2.0)
    assert station.command(CONDITION_YAW, 30, 0, 0, 0) == 0
    station.run(6.0)
    assert heading() == pytest.approx(30.0, abs=2.0)
    local(station, NO_ACCELERATION, Motion(yaw=-1.0, yaw_rate=0.2))
    station.run(2.6)
    assert heading() > math.degrees(-1.0) + 20.0
    local(station, NO_ACCELERATION | NO_YAW, Motion(yaw_rate=-0.5))
    before = heading()
    station.run(2.0)
    assert heading() == pytest.approx(before - math.degrees(1.0), abs=12.0)
    station.run(4.0)
    stopped = heading()
    station.run(2.0)
    assert heading() == pytest.approx(stopped, abs=2.0)
    local(station, NO_POSITION | NO_ACCELERATION | NO_TURN, Motion(velocity=(0.0, -3.0, 0.0)))
    station.run(2.9)
    assert heading() == pytest.approx(-90.0, abs=20.0)


def test_a_relative_heading_turns_with_the_body_frame() -> None:
    """In a body frame the heading is an angle from here."""
    autopilot, station = sim()
    station.fly()
    motion = Motion(ZERO, yaw=0.5)
    local(station, NO_VELOCITY | NO_ACCELERATION | NO_RATE, motion, BODY)
    station.run(6.0)
    assert autopilot.flight.attitude_rad[2] == pytest.approx(math.pi / 2 + 0.5, abs=0.05)


@pytest.mark.parametrize(
    ("kind", "position"),
    [(1, (0.0, 0.0, 31.0)), (2, (41.0, 0.0, 20.0)), (8, (0.0, 0.0, 4.0)), (15, (41.0, 0.0, 31.0))],
)
def test_targets_outside_the_fence_are_dropped(kind: int, position: tuple[float, float, float]) -> None:
    """By height and by distance from home, in every form; without FENCE_ENABLE there is no fence."""
    autopilot, station = sim(FENCE_TYPE=kind, FENCE_ALT_MAX=30, FENCE_RADIUS=40, FENCE_ALT_MIN=5)
    station.fly()
    autopilot.parameters.assign("FENCE_ENABLE", 1)
    before = told(station).type_mask
    outside = Motion(position)
    local(station, NO_TURN, outside)
    local(station, NO_VELOCITY | NO_ACCELERATION, outside)
    world(station, NO_TURN, outside)
    there = START.location_of(position)
    go = (there.lat_e7, there.lon_e7, position[2])
    assert station.command_int(192, RELATIVE, [-1, 0, 0, 0], go) == 4
    assert told(station).type_mask == before
    local(station, NO_TURN, Motion((10.0, 0.0, 20.0)))
    assert told(station).type_mask == NO_TURN
    autopilot.parameters.assign("FENCE_ENABLE", 0)
    local(station, NO_TURN, outside)
    assert (told(station).x, -told(station).z) == pytest.approx((position[0], position[2]))


def test_other_modes_and_the_ground_ignore_targets() -> None:
    """In LOITER the copter stays; back in GUIDED it has no target of before."""
    autopilot, station = sim()
    station.fly()
    station.mode(LOITER)
    local(station, NO_POSITION, Motion(velocity=(5.0, 0.0, 0.0)))
    station.run(3.0)
    assert autopilot.flight.velocity_m_s == pytest.approx(ZERO, abs=0.1)
    station.mode(GUIDED)
    station.run(3.0)
    assert autopilot.flight.velocity_m_s == pytest.approx(ZERO, abs=0.1)


def test_copter_3_3_takes_position_velocity_or_both() -> None:
    """Acceleration must be ignored, or all is dropped; headings are not taken; nonsense stops nothing."""
    firmware = replace(COPTER_3_3, unknown_commands=frozenset(), mavlink1=False, arming_delay_s=0.0)
    autopilot, station = sim(Faults(firmware=firmware))
    assert autopilot.parameters.find("GUID_TIMEOUT") is None
    station.fly()
    before = told(station).type_mask
    local(station, 0, ALL)
    local(station, NO_VELOCITY, ALL)
    assert told(station).type_mask == before
    assert station.command(CONDITION_YAW, 200, 0, 0, 0) == 0
    for _ in range(40):
        local(station, NO_ACCELERATION, Motion((0.0, 0.0, 20.0), yaw=0.0))
        station.run(0.1)
    assert math.degrees(autopilot.flight.attitude_rad[2]) % 360.0 == pytest.approx(200.0, abs=3.0)
    local(station, NO_POSITION | NO_ACCELERATION, Motion(velocity=(2.0, 0.0, 0.0)))
    station.run(2.0)
    local(station, NO_ACCELERATION, Motion(velocity=(2.0, 0.0, 0.0)), 4)
    station.run(0.9)
    assert autopilot.flight.velocity_m_s[0] > 1.0
    station.run(8.0)
    assert autopilot.flight.velocity_m_s == pytest.approx(ZERO, abs=0.1)


def test_guid_options_and_timeout_are_those_of_4_6() -> None:
    """The defaults, and their types."""
    autopilot, _ = sim()
    assert (autopilot.parameters["GUID_TIMEOUT"], autopilot.parameters["GUID_OPTIONS"]) == (3.0, 0.0)

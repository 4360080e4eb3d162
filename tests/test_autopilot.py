"""The autopilot on the ground and in the air: arming, take-off, modes; in vehicle time."""

from __future__ import annotations

import math

import pytest
from sim_station import (
    ARM,
    AUTO,
    GUIDED,
    LAND,
    LOITER,
    READY_S,
    RTL,
    TAKEOFF,
    sim,
    takeoff,
)

from flight_replay.simulator.faults import Faults
from flight_replay.simulator.mavlink import dialect
from flight_replay.simulator.modes import Mode

ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4


def test_it_is_not_armable_at_once_and_says_why() -> None:
    """Each stage of GPS and EKF refuses with its own reason, and within 10 s the vehicle is armable."""
    _, station = sim()
    station.mode(GUIDED)
    assert station.command(ARM, 1) == FAILED
    assert "Arm: GPS 1: Bad fix" in station.texts
    station.run(4)
    assert station.command(ARM, 1) == FAILED
    assert "Arm: AHRS: waiting for home" in station.texts
    station.run(2)
    assert station.command(ARM, 1) == FAILED
    assert "Arm: Need Position Estimate" in station.texts
    station.run(READY_S - 6)
    assert station.command(ARM, 1) == ACCEPTED


def test_prearm_failures_are_spoken_every_half_minute() -> None:
    """A vehicle that is never armable says so again and again, and refuses with the same words."""
    _, station = sim(Faults(never_armable="Compass not calibrated"))
    station.run(65)
    assert station.texts.count("PreArm: Compass not calibrated") == 2
    assert station.command(ARM, 1) == FAILED
    assert station.texts[-1] == "Arm: Compass not calibrated"
    station.command(dialect.MAV_CMD_RUN_PREARM_CHECKS)
    assert station.texts[-1] == "PreArm: Compass not calibrated"


def test_the_prearm_bit_tells_when_arming_would_pass() -> None:
    """SYS_STATUS shows the prearm check as healthy once the vehicle is armable."""
    autopilot, station = sim()
    station.mode(GUIDED)
    for seconds, passes in ((5, False), (READY_S, True)):
        station.run(seconds)
        station.channel.request(dialect.MAVLINK_MSG_ID_SYS_STATUS)
        healthy = station.last("SYS_STATUS").onboard_control_sensors_health
        assert bool(healthy & dialect.MAV_SYS_STATUS_PREARM_CHECK) == passes
    assert autopilot.prearm.passed


@pytest.mark.parametrize(
    ("parameter", "value", "reason"),
    [
        ("ANGLE_MAX", 100, "Check ANGLE_MAX"),
        ("PILOT_SPEED_UP", 0, "Check PILOT_SPEED_UP"),
        ("FS_THR_VALUE", 900, "Check FS_THR_VALUE"),
        ("FS_GCS_ENABLE", 2, "FS_GCS_ENABLE=2 removed, see FS_OPTIONS"),
        ("SIM_BATT_VOLTAGE", 9.5, "Battery 1 low voltage failsafe"),
        ("BATT_ARM_VOLT", 13, "Battery 1 below minimum arming voltage"),
        ("SIM_GPS_DISABLE", 1, "GPS 1: Bad fix"),
    ],
)
def test_parameters_keep_it_from_arming(parameter: str, value: float, reason: str) -> None:
    """What ArduCopter checks before arming is checked, and named; without checks it arms anyway."""
    _, station = sim()
    station.autopilot.parameters.assign(parameter, value)
    station.run(READY_S)
    station.mode(GUIDED)
    assert station.command(ARM, 1) == FAILED
    assert f"Arm: {reason}" in station.texts
    if parameter != "SIM_GPS_DISABLE":
        station.autopilot.parameters.assign("ARMING_CHECK", 0)
        assert station.command(ARM, 1) == ACCEPTED
        assert "Warning: Arming Checks Disabled" in station.texts


def test_force_skips_the_checks() -> None:
    """The magic number arms against a check, but not without a position in a mode that needs one."""
    _, station = sim(Faults(never_armable="Gyros not healthy"))
    station.mode(GUIDED)
    assert station.command(ARM, 1, 2989) == FAILED
    station.run(READY_S)
    assert station.command(ARM, 1) == FAILED
    assert station.command(ARM, 1, 2989) == ACCEPTED


@pytest.mark.parametrize("mode", [RTL, LAND, AUTO, Mode.BRAKE])
def test_some_modes_are_not_armable(mode: int) -> None:
    """Disarmed, any mode may be chosen; armed it may not be in these."""
    _, station = sim()
    station.run(READY_S)
    assert station.mode(mode) == ACCEPTED
    if mode == AUTO:
        assert station.command(ARM, 1) == FAILED
        assert station.texts[-1] == "Arm: Mode requires mission"
    station.upload([takeoff(10)])
    assert station.command(ARM, 1) == FAILED
    assert station.texts[-1] == f"Arm: {Mode(mode).name} mode not armable"


def test_an_idle_copter_disarms_after_ten_seconds() -> None:
    """DISARM_DELAY of vehicle time; 0 never."""
    autopilot, station = sim()
    station.run(READY_S)
    station.mode(GUIDED)
    station.command(ARM, 1)
    station.run(9.9)
    assert autopilot.armed
    station.run(0.3)
    assert not autopilot.armed
    assert station.texts[-1] == "Disarming motors"
    autopilot.parameters.assign("DISARM_DELAY", 0)
    station.command(ARM, 1)
    station.run(30)
    assert autopilot.armed


def test_a_flying_copter_is_not_disarmed_but_by_force() -> None:
    """The plain command is refused in the air; the magic number stops the motors, and the copter falls."""
    autopilot, station = sim()
    station.fly()
    assert station.command(ARM, 0) == FAILED
    assert autopilot.armed
    assert station.command(ARM, 0, 21196) == ACCEPTED
    assert not autopilot.armed
    assert autopilot.flight.landed
    assert station.command(ARM, 0) == ACCEPTED
    assert station.command(ARM, 7) == UNSUPPORTED


# take-off


def test_takeoff_needs_to_be_armed_on_the_ground_and_upwards() -> None:
    """NAV_TAKEOFF is refused disarmed, downwards, in the air, in a foreign frame and in AUTO."""
    _, station = sim()
    station.run(READY_S)
    station.mode(GUIDED)
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 10) == FAILED
    station.command(ARM, 1)
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, -1) == FAILED
    assert station.command_int(TAKEOFF, 0, [0, 0, 0, 0], (0, 0, 10.0)) == DENIED
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 10) == ACCEPTED
    station.run(15)
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 20) == FAILED
    station.mode(RTL)
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 30) == FAILED


def test_takeoff_takes_about_as_long_as_arducopters() -> None:
    """30 m in 15 to 18 s from the command, as recorded of ArduCopter 4.6, and then it stays there."""
    autopilot, station = sim()
    station.run(READY_S)
    station.mode(GUIDED)
    station.command(ARM, 1)
    station.run(1)
    station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 30)
    began_s = autopilot.time_s
    assert station.run(30, lambda: autopilot.above_home_m >= 28.5)
    assert 13 < autopilot.time_s - began_s < 18
    station.run(10)
    assert autopilot.above_home_m == pytest.approx(30, abs=0.2)
    assert autopilot.mode == Mode.GUIDED


def test_a_takeoff_that_does_not_climb_stays_armed_on_the_ground() -> None:
    """The fault accepts the command and goes nowhere."""
    autopilot, station = sim(Faults(climbs=False))
    station.run(READY_S)
    station.mode(GUIDED)
    station.command(ARM, 1)
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 30) == ACCEPTED
    station.run(60)
    assert autopilot.armed
    assert autopilot.above_home_m == 0


# modes


def test_modes_change_by_command_and_by_message() -> None:
    """DO_SET_MODE and SET_MODE both work; unknown modes are refused, with a text; each change is heard."""
    autopilot, station = sim()
    station.forget()
    assert station.mode(LOITER) == ACCEPTED
    assert station.last("HEARTBEAT").custom_mode == LOITER
    station.send(dialect.MAVLink_set_mode_message(1, 1, GUIDED))
    assert autopilot.mode == Mode.GUIDED
    station.send(dialect.MAVLink_set_mode_message(1, 0, LOITER))
    assert autopilot.mode == Mode.GUIDED
    assert station.mode(99) == FAILED
    assert station.texts[-1] == "No such mode 99"
    assert station.command(176, 0, LOITER) == DENIED


def test_modes_can_be_blocked_and_refused() -> None:
    """FLTMODE_GCSBLOCK and a fault script keep a station out, with a reason."""
    _, station = sim(Faults(refused_modes={RTL: "the fault script says so"}), FLTMODE_GCSBLOCK=1 << 3)
    assert station.mode(AUTO) == FAILED
    assert station.texts[-1] == "Mode change to AUTO failed: GCS entry disabled (FLTMODE_GCSBLOCK)"
    assert station.mode(RTL) == FAILED
    assert station.texts[-1] == "Mode change to RTL failed: the fault script says so"


def test_modes_that_need_a_position_are_refused_in_flight_without_one() -> None:
    """With the GPS gone for longer than the EKF coasts, LOITER is refused and LAND is not."""
    autopilot, station = sim()
    station.fly()
    autopilot.parameters.assign("SIM_GPS_DISABLE", 1)
    station.run(6)
    assert station.mode(LOITER) == FAILED
    assert station.texts[-1] == "Mode change to LOITER failed: requires position"
    assert station.mode(LAND) == ACCEPTED
    autopilot.parameters.assign("SIM_GPS_DISABLE", 0)
    station.run(1)
    assert station.mode(LOITER) == ACCEPTED


@pytest.mark.parametrize("mode", [Mode.LOITER, Mode.BRAKE, Mode.ALT_HOLD, Mode.POSHOLD, Mode.STABILIZE])
def test_the_other_modes_hold_the_place(mode: Mode) -> None:
    """Without a pilot's sticks, a copter that flew along comes to rest and stays."""
    autopilot, station = sim()
    station.fly()
    autopilot.flight.drift((5.0, 0.0, 0.0))
    station.run(8)
    station.mode(mode)
    station.run(8)
    stopped = autopilot.flight.position_m
    station.run(10)
    assert math.dist(stopped, autopilot.flight.position_m) < 0.2


def test_an_arm_command_can_be_refused_though_all_checks_pass() -> None:
    """A fault script's reason meets the arm command alone."""
    autopilot, station = sim(Faults(refuses_arming="Safety Switch"))
    station.run(READY_S)
    assert autopilot.prearm.passed
    assert station.command(ARM, 1) == FAILED
    assert station.texts[-1] == "Arm: Safety Switch"


def test_answers_come_before_the_texts_that_explain_them() -> None:
    """As ArduPilot queues its texts, COMMAND_ACK is there first, the reason a step later."""
    _, station = sim(Faults(never_armable="Logging failed"))
    station.run(READY_S)
    station.forget()
    station.command(ARM, 1)
    assert [message.get_type() for message in station.heard] == ["COMMAND_ACK"]
    station.run(0.04)
    assert station.last("STATUSTEXT").text == "Arm: Logging failed"

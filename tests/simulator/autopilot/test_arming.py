"""Arming and disarming, and the reasons against; in vehicle time."""

from __future__ import annotations

import pytest

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.faults import Faults
from tests.helpers.sim_station import (
    ACCEPTED,
    ARM,
    AUTO,
    FAILED,
    GUIDED,
    LAND,
    READY_S,
    RTL,
    UNSUPPORTED,
    sim,
    takeoff,
)


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
    _, station = sim(Faults(prearm_failure="Compass not calibrated"))
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
    _, station = sim(Faults(prearm_failure="Gyros not healthy"))
    station.mode(GUIDED)
    assert station.command(ARM, 1, 2989) == FAILED
    station.run(READY_S)
    assert station.command(ARM, 1) == FAILED
    assert station.command(ARM, 1, 2989) == ACCEPTED


@pytest.mark.parametrize("mode", [RTL, LAND, AUTO, CopterMode.BRAKE])
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
    assert station.texts[-1] == f"Arm: {CopterMode(mode).name} mode not armable"


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


def test_an_arm_command_can_be_refused_though_all_checks_pass() -> None:
    """A fault script's reason meets the arm command alone."""
    autopilot, station = sim(Faults(arm_failure="Safety Switch"))
    station.run(READY_S)
    assert autopilot.prearm.passed
    assert station.command(ARM, 1) == FAILED
    assert station.texts[-1] == "Arm: Safety Switch"


def test_answers_come_before_the_texts_that_explain_them() -> None:
    """As ArduPilot queues its texts, COMMAND_ACK is there first, the reason a step later."""
    _, station = sim(Faults(prearm_failure="Logging failed"))
    station.run(READY_S)
    station.clear()
    station.command(ARM, 1)
    assert [message.get_type() for message in station.received] == ["COMMAND_ACK"]
    station.run(0.04)
    assert station.last("STATUSTEXT").text == "Arm: Logging failed"

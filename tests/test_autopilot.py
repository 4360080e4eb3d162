"""The autopilot: arming, modes, take-off, missions, coming home; in vehicle time."""

from __future__ import annotations

import math

import pytest
from sim_station import (
    ARM,
    AUTO,
    GUIDED,
    LAND,
    LOITER,
    MISSION_START,
    READY_S,
    RTL,
    TAKEOFF,
    act,
    place,
    sim,
    takeoff,
)

from flight_replay.simulator.faults import Faults
from flight_replay.simulator.mavlink import dialect
from flight_replay.simulator.modes import Mode
from flight_replay.simulator.place import Start

ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4
SQUARE = [place(40, 0), place(40, 40), place(0, 40)]


def reached(station):  # type: ignore[no-untyped-def]
    return [message.seq for message in station.of("MISSION_ITEM_REACHED")]


# arming


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
    _, station = sim(**{parameter: value})
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


# missions


def test_auto_from_the_ground_needs_a_takeoff_item() -> None:
    """Armed on the ground, a mission without a take-off is refused with ArduCopter's words."""
    _, station = sim()
    station.run(READY_S)
    station.upload(SQUARE)
    station.mode(GUIDED)
    station.command(ARM, 1)
    assert station.mode(AUTO) == FAILED
    assert "Auto: Missing Takeoff Cmd" in station.texts
    assert station.texts[-1] == "Mode change to AUTO failed: init failed"


def test_auto_in_the_air_needs_a_mission() -> None:
    """Without items, AUTO is refused in flight."""
    autopilot, station = sim()
    station.fly()
    assert station.mode(AUTO) == FAILED
    assert autopilot.mode == Mode.GUIDED


def test_a_mission_is_flown_item_by_item() -> None:
    """Each item is announced, reached and counted; after the last the copter stays, still in AUTO."""
    autopilot, station = sim()
    station.fly()
    station.upload(SQUARE)
    assert station.mode(AUTO) == ACCEPTED
    assert station.run(120, lambda: 3 in reached(station))
    assert reached(station) == [1, 2, 3]
    for text in ("Mission: 1 WP", "Reached command #1", "Mission: 3 WP", "Reached command #3"):
        assert text in station.texts
    station.run(5)
    station.channel.request(dialect.MAVLINK_MSG_ID_MISSION_CURRENT)
    current = station.last("MISSION_CURRENT")
    assert (current.seq, current.total, current.mission_state, current.mission_mode) == (3, 3, 5, 1)
    assert autopilot.mode == Mode.AUTO
    north_m, east_m, up_m = autopilot.flight.position_m
    assert math.dist((north_m, east_m, up_m), (0, 40, 20)) < 1


def test_do_items_take_the_place_of_the_item_before_in_the_report() -> None:
    """A DO item is done at once, and of one instant only the last item is reported, as ArduCopter does."""
    _, station = sim()
    station.fly()
    station.upload([place(30, 0), act(178, 1, 3, -1), place(30, 30)])
    station.mode(AUTO)
    assert station.run(120, lambda: 3 in reached(station))
    assert reached(station) == [2, 3]
    assert station.texts.index("Mission: 2 ChangeSpeed") < station.texts.index("Mission: 3 WP")


def test_a_whole_mission_from_takeoff_to_landing() -> None:
    """MISSION_START lifts off by itself; RTL as an item lands and disarms, and the mission is reset."""
    autopilot, station = sim(AUTO_OPTIONS=1)
    station.run(READY_S)
    station.upload([takeoff(15), place(30, 0), act(20)])
    station.mode(AUTO)
    assert station.command(ARM, 1) == ACCEPTED
    station.run(3)
    assert autopilot.flight.landed
    assert station.command(MISSION_START) == ACCEPTED
    assert station.run(200, lambda: not autopilot.armed)
    assert {1, 2} <= set(reached(station))
    assert math.dist(autopilot.flight.position_m, (0, 0, 0)) < 0.5
    assert autopilot.mission.seq == 0


def test_a_mission_goes_on_where_it_was_left() -> None:
    """MIS_RESTART 0 resumes, 1 begins anew."""
    autopilot, station = sim()
    station.fly()
    station.upload(SQUARE)
    station.mode(AUTO)
    station.run(60, lambda: autopilot.mission.seq == 2)
    station.mode(LOITER)
    station.run(3)
    station.mode(AUTO)
    station.run(1)
    assert autopilot.mission.seq == 2
    autopilot.parameters.assign("MIS_RESTART", 1)
    station.mode(LOITER)
    station.mode(AUTO)
    station.run(1)
    assert autopilot.mission.seq == 1


def test_a_station_chooses_the_current_item() -> None:
    """MISSION_SET_CURRENT and DO_SET_MISSION_CURRENT jump, before and during the flight."""
    autopilot, station = sim()
    station.fly()
    station.upload(SQUARE)
    station.send(dialect.MAVLink_mission_set_current_message(1, 1, 2))
    assert station.last("MISSION_CURRENT").seq == 2
    station.mode(AUTO)
    station.run(1)
    assert autopilot.mission.seq == 2
    assert station.command(224, 3) == ACCEPTED
    station.run(1)
    assert autopilot.mission.seq == 3
    assert station.command(224, 9) == DENIED


def test_a_running_mission_is_not_cleared() -> None:
    """MISSION_CLEAR_ALL fails while the mission is flown, and works otherwise."""
    autopilot, station = sim()
    station.fly()
    station.upload(SQUARE)
    station.mode(AUTO)
    station.run(1)
    station.send(dialect.MAVLink_mission_clear_all_message(1, 1))
    assert station.last("MISSION_ACK").type == dialect.MAV_MISSION_ERROR
    station.mode(LOITER)
    station.send(dialect.MAVLink_mission_clear_all_message(1, 1))
    assert station.last("MISSION_ACK").type == dialect.MAV_MISSION_ACCEPTED
    assert len(autopilot.store) == 0


def test_a_mission_changed_in_flight_is_flown_as_changed() -> None:
    """New items near the current one restart its leg, with a text; farther ones are just flown later."""
    autopilot, station = sim()
    station.fly()
    station.upload([*SQUARE, place(0, 0), place(-40, 0)])
    station.mode(AUTO)
    station.run(1)
    for seq, moved, restarts in ((5, place(-20, 0), False), (1, place(25, 0), True)):
        station.forget()
        station.send(dialect.MAVLink_mission_write_partial_list_message(1, 1, seq, seq))
        command, frame, params, x, y, z = moved
        station.send(
            dialect.MAVLink_mission_item_int_message(1, 1, seq, frame, command, 0, 1, *params, x, y, z)
        )
        station.run(1)
        assert ("Auto mission changed, restarted command" in station.texts) == restarts
    assert station.run(200, lambda: 5 in reached(station))
    assert math.dist(autopilot.flight.position_m, (-20, 0, 20)) < 3


# coming home


def test_rtl_climbs_returns_waits_and_lands() -> None:
    """From below RTL_ALT the copter climbs to it first, then flies home, lands and disarms there."""
    autopilot, station = sim(RTL_ALT=2500)
    station.fly(10)
    autopilot.flight.goto((40.0, 0.0, 10.0))
    station.run(20)
    assert station.command(dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH) == ACCEPTED
    highest = 0.0
    while autopilot.armed:
        station.run(1)
        highest = max(highest, autopilot.above_home_m)
        assert autopilot.time_s < 200
    assert highest == pytest.approx(25, abs=0.5)
    assert math.dist(autopilot.flight.position_m, (0, 0, 0)) < 0.5
    assert autopilot.mode == Mode.RTL


def test_land_comes_down_here() -> None:
    """LAND descends where it is and disarms."""
    autopilot, station = sim()
    station.fly(15)
    autopilot.flight.goto((30.0, 10.0, 15.0))
    station.run(20)
    assert station.command(dialect.MAV_CMD_NAV_LAND) == ACCEPTED
    assert station.run(60, lambda: not autopilot.armed)
    assert math.dist(autopilot.flight.position_m, (30, 10, 0)) < 1


def test_home_is_where_it_was_armed() -> None:
    """After landing elsewhere, arming moves home there: heights and RTL count from it."""
    autopilot, station = sim()
    station.fly(10)
    autopilot.flight.goto((50.0, 20.0, 10.0))
    station.run(20)
    station.mode(LAND)
    station.run(60, lambda: not autopilot.armed)
    station.fly(10)
    assert autopilot.home is not None
    assert math.dist(autopilot.home.position_m, (50, 20, 0)) < 1
    autopilot.flight.goto((80.0, 20.0, 10.0))
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
    there = start.place_of((60.0, 60.0, 0.0))
    station.upload([(16, 3, (0.0, 0.0, 0.0, 0.0), there.lat_e7, there.lon_e7, 10.0)])
    station.mode(AUTO)
    assert station.run(60, lambda: reached(station) == [1])
    assert math.dist(autopilot.flight.position_m, (60, 60, 10)) < 2.5

"""Take-off and modes; in vehicle time."""

from __future__ import annotations

import math

import pytest

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.flight.copter import STEP_S
from flight_replay.simulator.flight.guided import GuidedTarget
from tests.helpers.sim_station import (
    ACCEPTED,
    ARM,
    AUTO,
    DENIED,
    FAILED,
    GUIDED,
    LAND,
    LOITER,
    READY_S,
    RTL,
    START,
    TAKEOFF,
    sim,
)


def test_takeoff_needs_to_be_armed_on_the_ground_and_upwards() -> None:
    """NAV_TAKEOFF is refused disarmed, downwards, in the air, in a foreign frame and in AUTO."""
    _, station = sim()
    station.run(READY_S)
    station.mode(GUIDED)
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 10) == FAILED
    station.command(ARM, 1)
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, -1) == FAILED
    for frame in (dialect.MAV_FRAME_GLOBAL, dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT):
        assert station.command_int(TAKEOFF, frame, [0, 0, 0, 0], (0, 0, 10.0)) == DENIED
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
    assert autopilot.mode == CopterMode.GUIDED


def test_a_takeoff_that_does_not_climb_stays_armed_on_the_ground() -> None:
    """The fault accepts the command and goes nowhere."""
    autopilot, station = sim(Faults(takeoff_climbs=False))
    station.run(READY_S)
    station.mode(GUIDED)
    station.command(ARM, 1)
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 30) == ACCEPTED
    station.run(60)
    assert autopilot.armed
    assert autopilot.above_home_m == 0


def test_modes_change_by_command_and_by_message() -> None:
    """DO_SET_MODE and SET_MODE both work; unknown modes are refused, with a text; each change is heard."""
    autopilot, station = sim()
    station.clear()
    assert station.mode(LOITER) == ACCEPTED
    assert station.last("HEARTBEAT").custom_mode == LOITER
    station.send(dialect.MAVLink_set_mode_message(1, 1, GUIDED))
    assert autopilot.mode == CopterMode.GUIDED
    station.send(dialect.MAVLink_set_mode_message(1, 0, LOITER))
    assert autopilot.mode == CopterMode.GUIDED
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


@pytest.mark.parametrize(
    "mode",
    [CopterMode.LOITER, CopterMode.BRAKE, CopterMode.ALT_HOLD, CopterMode.POSHOLD, CopterMode.STABILIZE],
)
def test_the_other_modes_hold_the_position(mode: CopterMode) -> None:
    """Without a pilot's sticks, a copter that flew along comes to rest and stays."""
    autopilot, station = sim()
    station.fly()
    autopilot.parameters.assign("GUID_TIMEOUT", 60)
    autopilot.flight.follow(GuidedTarget(velocity_m_s=(5.0, 0.0, 0.0)))
    station.run(8)
    station.mode(mode)
    station.run(8)
    stopped = autopilot.flight.position_m
    station.run(10)
    assert math.dist(stopped, autopilot.flight.position_m) < 0.2


class Observer:
    """Records what an autopilot reports, by the name of the report."""

    def __init__(self) -> None:
        self.reports: list[str] = []

    def status_text(self, severity: Severity, text: str) -> None:
        self.reports.append(text)

    def home_changed(self) -> None:
        self.reports.append("home")

    def mode_changed(self) -> None:
        self.reports.append("mode")

    def item_reached(self, seq: int) -> None:
        self.reports.append(f"item {seq}")

    def rebooted(self) -> None:
        self.reports.append("boot")


def test_it_flies_without_a_link_and_reports_to_its_observers() -> None:
    """The autopilot itself needs no MAVLink: commands are calls, and reports go to whoever observes."""
    autopilot, observer = Autopilot(START), Observer()
    autopilot.observers.append(observer)
    for _ in range(round(READY_S / STEP_S)):
        autopilot.step()
    observer.reports.clear()
    assert autopilot.request_mode(CopterMode.GUIDED)
    assert autopilot.arming.arm()
    assert observer.reports == ["mode", "Arming motors", "home"]
    autopilot.flight.takeoff(10.0)
    for _ in range(round(15.0 / STEP_S)):
        autopilot.step()
    assert autopilot.above_home_m > 9.0
    autopilot.reboot()
    assert observer.reports[-1] == "boot"
    assert not autopilot.armed

"""The fault table: faults of the link, the autopilot, the pilot and other stations.

Each row keeps the promises: no mission is flown that was not verified on board; no wait is longer
than its deadline; the error line is right; an armed vehicle that can be reached is commanded to
return, and whether it confirmed RTL is reported.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from flight_replay.events import LinkLost, LinkRestored, Notice, Waiting
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.autopilot import faults as sim
from flight_replay.simulator.autopilot.faults import Faults, MissionFaults, ScriptedFault
from tests.helpers.fault_link import FOREVER_S, FaultLink, Message, Trigger
from tests.helpers.fault_runs import ROUTE, FaultRun, replay, requested_mode
from tests.helpers.link_conditions import LinkConditions

pytestmark = pytest.mark.realtime

AUTO, GUIDED, LOITER = CopterMode.AUTO, CopterMode.GUIDED, CopterMode.LOITER
RTL, LAND = CopterMode.RTL, CopterMode.LAND
MAX_WALL_S = 120.0
"""The sum of the deadlines that one row can reach, in wall-clock time."""


def assert_promises(outcome: FaultRun) -> None:
    """The promises that every row keeps."""
    assert outcome.wall_s < MAX_WALL_S
    assert outcome.line is None or "\n" not in outcome.line
    if AUTO in outcome.modes_requested():
        assert_verified_before_auto(outcome.link)


def assert_verified_before_auto(link: FaultLink) -> None:
    """Every item was read back between the upload and AUTO."""
    messages = link.to_vehicle
    auto = next(i for i, message in enumerate(messages) if requested_mode(message) == AUTO)
    upload = max(i for i, m in enumerate(messages[:auto]) if m.get_type() == "MISSION_ITEM_INT")
    read_back = {m.seq for m in messages[upload:auto] if m.get_type() == "MISSION_REQUEST_INT"}
    assert read_back >= set(range(1, len(ROUTE.items) + 1))


# The link

CONDITIONS = {
    "clear": (LinkConditions(), 10.0),
    "5 % lost": (LinkConditions(loss=0.05), 10.0),
    "20 % lost": (LinkConditions(loss=0.2), 10.0),
    "corrupt": (LinkConditions(corrupt=0.05), 10.0),
    "duplicated": (LinkConditions(duplicated=0.3), 10.0),
    "40 % lost": (LinkConditions(loss=0.4), 10.0),
    "late": (LinkConditions(delay_s=0.5), 4.0),
    "mixed": (LinkConditions(loss=0.1, corrupt=0.05, duplicated=0.1, delay_s=0.02, jitter_s=0.1), 10.0),
}
QUICK = {"5 % lost"}
BUSY_S = 0.5
"""How late a program on a busy machine may see the vehicle's time, in wall-clock time."""


def marked(names: list[str], slow: set[str]) -> list[object]:
    """Names as parameters; those in ``slow`` carry the marker."""
    return [pytest.param(name, marks=pytest.mark.slow if name in slow else ()) for name in names]


@pytest.mark.parametrize("name", marked(list(CONDITIONS), set(CONDITIONS) - QUICK))
def test_a_bad_link_does_not_change_the_flight(name: str) -> None:
    """Frames that are lost, late, duplicated, reordered or corrupt cost time only."""
    conditions, speedup = CONDITIONS[name]
    outcome = replay(None, conditions, speedup=speedup)
    assert_promises(outcome)
    assert outcome.line is None
    assert outcome.record is not None
    assert outcome.record.ended == "duration"
    assert 11 < outcome.record.auto_s < 12 + BUSY_S * speedup
    assert outcome.modes_requested() == [GUIDED, AUTO, RTL]
    assert outcome.rtl_confirmed


def anything(message: Message) -> bool:
    return True


def kind(name: str, **values: int) -> Callable[[Message], bool]:
    """A message of a type, with these fields."""
    return lambda m: m.get_type() == name and all(getattr(m, k) == v for k, v in values.items())


def command(number: int) -> Callable[[Message], bool]:
    return kind("COMMAND_LONG", command=number)


def requests_mode(mode: int) -> Callable[[Message], bool]:
    return lambda m: requested_mode(m) == mode


def in_mode(mode: int) -> Callable[[Message], bool]:
    """A heartbeat of the copter in a mode."""
    return lambda m: kind("HEARTBEAT", custom_mode=mode)(m) and m.get_srcSystem() == 1


MOMENTS: dict[str, Callable[[Message], bool]] = {
    "connect": anything,
    "upload": kind("MISSION_ITEM_INT", seq=12),
    "read-back": kind("MISSION_REQUEST_INT", seq=9),
    "arming": command(400),
    "take-off": command(22),
    "AUTO": in_mode(AUTO),
    "RTL": requests_mode(RTL),
}


@pytest.mark.parametrize("moment", marked(list(MOMENTS), set(MOMENTS)))
def test_a_silence_of_three_seconds_does_not_end_the_flight(moment: str) -> None:
    """Afterwards the flight goes on and ends as asked."""
    cut = Trigger(MOMENTS[moment], lambda link: link.cut(3.0))
    outcome = replay(None, None, cut, duration_s=100.0)
    assert_promises(outcome)
    assert outcome.line is None
    assert outcome.rtl_confirmed


ERRORS = {
    "connect": "no heartbeat of a vehicle on",
    "upload": "upload stopped at mission item",
    "read-back": "cannot download mission item",
    "arming": "no data for",
    "take-off": "no data for",
    "AUTO": "no data for",
    "RTL": "did not confirm RTL: no data for",
}


@pytest.mark.parametrize("moment", marked(list(MOMENTS), set(MOMENTS)))
def test_a_link_that_is_cut_for_ever_ends_the_program(moment: str) -> None:
    """The error says where the link was lost; in the air the loss is reported within 5 s."""
    cut = Trigger(MOMENTS[moment], lambda link: link.cut(FOREVER_S))
    outcome = replay(None, None, cut, connect_s=8.0 if moment == "connect" else 30.0)
    assert_promises(outcome)
    assert ERRORS[moment] in (outcome.line or "")
    assert not outcome.rtl_confirmed
    if moment in ("arming", "take-off", "AUTO", "RTL"):
        (lost,) = outcome.link_events
        assert isinstance(lost, LinkLost)
        assert lost.silent_s < 5


@pytest.mark.slow
def test_a_restored_link_is_used_again() -> None:
    """A silence of 6 s in AUTO is reported, and the flight ends as asked."""
    outcome = replay(None, None, Trigger(in_mode(AUTO), lambda link: link.cut(6.0)), duration_s=120.0)
    assert_promises(outcome)
    assert [type(event) for event in outcome.link_events] == [LinkLost, LinkRestored]
    assert outcome.line is None
    assert outcome.rtl_confirmed


@pytest.mark.parametrize(
    "moment", marked(["connect", "upload", "take-off", "AUTO"], {"connect", "upload", "take-off"})
)
def test_a_connection_that_is_closed_is_opened_again(moment: str) -> None:
    """A TCP connection that ends is opened again, and the flight goes on."""
    outcome = replay(None, None, Trigger(MOMENTS[moment], FaultLink.disconnect))
    assert_promises(outcome)
    assert outcome.line is None
    assert outcome.rtl_confirmed


# The autopilot


def at(moment: str, after_s: float, action: sim.Action) -> Faults:
    """A vehicle with one fault."""
    return Faults(script=(ScriptedFault(moment, after_s, action),))


REBOOT_SPEEDUP = 10.0
"""The vehicle's new clock must be received before it reaches the time of the old one."""


@pytest.mark.slow
def test_a_reboot_in_the_air_ends_the_flight() -> None:
    """The error says so, and nothing more is flown."""
    outcome = replay(at("AUTO", 5.0, sim.Reboot()), speedup=REBOOT_SPEEDUP, duration_s=200.0)
    assert_promises(outcome)
    assert "rebooted" in (outcome.line or "")
    assert outcome.record is not None
    assert outcome.record.ended == "reboot"


@pytest.mark.slow
def test_a_reboot_on_the_ground_ends_the_flight_before_it_began() -> None:
    """A vehicle that rebooted after its mission was verified is not armed."""
    faults = Faults(
        prearm_failure="Compass not calibrated",
        script=(ScriptedFault("upload", 30.0, sim.Reboot()),),
    )
    outcome = replay(faults, speedup=REBOOT_SPEEDUP)
    assert_promises(outcome)
    assert "rebooted" in (outcome.line or "")
    assert not outcome.was_armed()


@pytest.mark.parametrize(("result", "reason"), [(5, "invalid")])
def test_a_refused_mission_is_not_flown(result: int, reason: str) -> None:
    """The error names item and reason (every code: test_mission_upload.py), and nothing is armed."""
    outcome = replay(Faults(mission=MissionFaults(result_of_item={7: result})))
    assert_promises(outcome)
    assert "mission item 7" in (outcome.line or "")
    assert reason in (outcome.line or "")
    assert not outcome.was_armed()


@pytest.mark.parametrize("moment", ["GUIDED", "armed"], ids=["before arming", "later"])
def test_a_mission_changed_by_another_station_is_not_flown(moment: str) -> None:
    """The mission on board is read again before arming and before AUTO.

    A change right after the upload would be corrected by the read-back of the upload.
    """
    outcome = replay(at(moment, 0.0, sim.MoveItem(len(ROUTE.items))))
    assert_promises(outcome)
    assert "another ground station changed it" in (outcome.line or "")
    assert AUTO not in outcome.modes_requested()
    assert outcome.was_armed() == outcome.rtl_confirmed


@pytest.mark.slow
def test_a_vehicle_that_never_is_ready_is_not_armed() -> None:
    """The autopilot's reason is shown while waiting, and in the error."""
    reason = "PreArm: Compass not calibrated"
    outcome = replay(Faults(prearm_failure="Compass not calibrated"))
    assert_promises(outcome)
    assert reason in (outcome.line or "")
    assert any(isinstance(event, Waiting) and event.reason == reason for event in outcome.events)
    assert not outcome.was_armed()


@pytest.mark.slow
def test_an_arming_that_is_refused_ends_the_flight() -> None:
    """The error has the autopilot's reason."""
    outcome = replay(Faults(arm_failure="Throttle too high"))
    assert_promises(outcome)
    assert "did not arm" in (outcome.line or "")
    assert "Throttle too high" in (outcome.line or "")
    assert not outcome.was_armed()


@pytest.mark.slow
@pytest.mark.parametrize(("mode", "name", "home"), [(GUIDED, "GUIDED", False), (AUTO, "AUTO", True)])
def test_a_mode_that_is_refused_ends_the_flight(mode: int, name: str, home: bool) -> None:
    """If GUIDED is refused the vehicle stays on the ground; if AUTO is refused it returns."""
    outcome = replay(Faults(refused_modes={mode: "Mode change failed: no"}))
    assert_promises(outcome)
    assert f"did not change to {name}" in (outcome.line or "")
    assert outcome.rtl_confirmed is home


@pytest.mark.slow
def test_a_refused_rtl_is_an_error() -> None:
    """The error asks to take control of the vehicle."""
    outcome = replay(Faults(refused_modes={RTL: "Mode change failed: no"}))
    assert_promises(outcome)
    assert "did not confirm RTL" in (outcome.line or "")


@pytest.mark.slow
def test_a_take_off_that_does_not_climb_ends_in_rtl() -> None:
    """The error has the altitude that was reached."""
    outcome = replay(Faults(takeoff_climbs=False))
    assert_promises(outcome)
    assert "did not climb above" in (outcome.line or "") or "before take-off" in (outcome.line or "")
    assert AUTO not in outcome.modes_requested()


@pytest.mark.parametrize("moment", marked(["takeoff", "AUTO"], {"takeoff"}))
def test_a_pilot_who_takes_over_is_not_overruled(moment: str) -> None:
    """After a mode change by the pilot no mode is commanded."""
    outcome = replay(at(moment, 3.0, sim.PilotMode(LOITER)), duration_s=200.0)
    assert_promises(outcome)
    assert "LOITER by the pilot" in (outcome.line or "")
    assert outcome.modes_requested() == ([GUIDED, AUTO] if moment == "AUTO" else [GUIDED])


@pytest.mark.parametrize(("mode", "name"), [pytest.param(RTL, "RTL", marks=pytest.mark.slow), (LAND, "LAND")])
def test_a_failsafe_is_accepted(mode: int, name: str) -> None:
    """It is reported with the autopilot's text, and not overruled."""
    outcome = replay(at("AUTO", 3.0, sim.FailsafeMode(mode, "Radio Failsafe")), duration_s=200.0)
    assert_promises(outcome)
    assert f"changed to {name} by itself: Radio Failsafe" in (outcome.line or "")
    assert outcome.modes_requested() == [GUIDED, AUTO]


@pytest.mark.slow
def test_a_battery_failsafe_is_accepted() -> None:
    """It is reported with the autopilot's text, and not overruled."""
    drained = at("AUTO", 3.0, sim.SetParameter("SIM_BATT_VOLTAGE", 9.0))
    outcome = replay(drained, duration_s=200.0, BATT_FS_LOW_ACT=2.0, BATT_LOW_VOLT=10.5)
    assert_promises(outcome)
    assert "changed to RTL by itself" in (outcome.line or "")
    assert "attery" in (outcome.line or "")
    assert outcome.modes_requested() == [GUIDED, AUTO]


# Others on the link

OTHERS = {
    "gimbal": sim.GIMBAL,
    "radio": sim.RADIO,
    "ADS-B": sim.ADSB_RECEIVER,
    "second copter": sim.SECOND_COPTER,
}


@pytest.mark.parametrize("name", marked(list(OTHERS), set(OTHERS) - {"second copter"}))
def test_heartbeats_of_other_components_are_ignored(name: str) -> None:
    """Of a gimbal, a radio, an ADS-B receiver and a second copter."""
    outcome = replay(Faults(other_heartbeats=(OTHERS[name],)))
    assert_promises(outcome)
    assert outcome.line is None
    assert outcome.rtl_confirmed
    notices = [event.text for event in outcome.events if isinstance(event, Notice)]
    assert notices == (["vehicle 2 is also on this link; it is ignored"] if name == "second copter" else [])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("firmware", "vehicle_type"), [(sim.PLANE, "fixed wing"), (sim.ROVER, "ground rover")]
)
def test_other_vehicles_are_refused(firmware: sim.Firmware, vehicle_type: str) -> None:
    """A plane or a rover is refused before anything is uploaded."""
    outcome = replay(Faults(firmware=firmware))
    assert_promises(outcome)
    assert f"{vehicle_type}, system 1) is not a multicopter" in (outcome.line or "")
    assert not [m for m in outcome.link.to_vehicle if m.get_type() == "MISSION_COUNT"]


@pytest.mark.slow
def test_arducopter_3_3_is_flown() -> None:
    """It has MAVLink 1, float items, SET_MODE, and takes 2.5 s to arm."""
    outcome = replay(sim.old_copter(), speedup=2.0)
    assert outcome.line is None
    assert outcome.rtl_confirmed
    arms = [m for m in outcome.link.to_vehicle if command(400)(m)]
    assert len(arms) == 1

"""The fault table of ``--mode guided``: the link, the autopilot, the pilot and other stations.

Each row keeps the promises: RTL is commanded unless somebody took over, and is confirmed where the
vehicle can be reached; nothing is sent after a take-over; no gap in the stream makes the vehicle rush.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

from flight_replay.events import Event, Following, LinkLost, LinkRestored
from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot import faults as sim
from flight_replay.simulator.autopilot.faults import Faults, ScriptedFault
from tests.cli.test_faults import MAX_WALL_S, at, kind
from tests.helpers.fault_link import FOREVER_S, FaultLink, Message, Trigger
from tests.helpers.follow_runs import TOP_SPEED_M_S, FollowRun, follow, is_in_mode, is_target
from tests.helpers.link_conditions import LinkConditions

GUIDED, LOITER, RTL, LAND = CopterMode.GUIDED, CopterMode.LOITER, CopterMode.RTL, CopterMode.LAND
TARGETS_PER_S = 10.0
HASTE = 20.0
"""Speedup of a simulator at which people are in a hurry."""
NO_RUSH_M_S = 2.5
"""The reference is rejoined at 2 m/s beside its own speed."""

pytestmark = pytest.mark.realtime


def assert_returned(run: FollowRun, speedup: float = 1.0) -> None:
    """The flight ended as asked: in RTL, without having rushed.

    In haste what a busy machine does late is many metres late, too: then it may end for that, in RTL as well.
    """
    assert run.wall_s < MAX_WALL_S
    assert run.record is not None
    if speedup == 1.0 or run.record.ended != "off course":
        assert run.line is None
        assert run.record.ended == "duration"
    assert run.rtl_confirmed
    assert run.modes_requested() == [GUIDED, RTL]
    assert_no_rush(run)


def assert_no_rush(run: FollowRun) -> None:
    assert run.speeds_m_s().max() < TOP_SPEED_M_S + NO_RUSH_M_S


def assert_left_alone(run: FollowRun, mode: CopterMode, speedup: float = 10.0) -> None:
    """From the first heartbeat in a mode on, the vehicle gets nothing any more but its parameter back."""
    assert run.wall_s < MAX_WALL_S
    assert run.line is not None and "\n" not in run.line
    assert RTL not in run.modes_requested()
    sent = [m for m in run.after_mode(mode) if m.get_type() not in {"PARAM_SET", "PARAM_REQUEST_READ"}]
    on_their_way = 2 + speedup * TARGETS_PER_S * 0.15
    assert len(sent) <= on_their_way, [m.get_type() for m in sent]


def nth_target(number: int) -> Callable[[Message], bool]:
    """True of the so manyeth target that moves, on its way to the vehicle."""
    left = [number]

    def matches(message: Message) -> bool:
        left[0] -= is_target(message)
        return left[0] <= 0 and is_target(message)

    return matches


def when_following(act: Callable[[FaultLink], None], targets: int = 100) -> Trigger:
    """Do something to the link when so many targets were sent."""
    return Trigger(nth_target(targets), act)


def on_the_way(act: Callable[[FaultLink], None]) -> Trigger:
    """Do something to the link when the vehicle is sent to where the recording begins."""
    return Trigger(kind("SET_POSITION_TARGET_GLOBAL_INT"), act)


# The link

CONDITIONS = {
    "10 % lost": (LinkConditions(loss=0.1), 0.3, 1.0),
    "30 % lost": (LinkConditions(loss=0.3), 0.5, 2.0),
    "late": (LinkConditions(delay_s=0.15), 0.3, 1.0),
    "jitter": (LinkConditions(jitter_s=0.1), 0.3, 1.0),
    "mixed": (LinkConditions(0.1, 0.02, 0.1, 0.05, 0.05), 0.5, 2.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("speedup", [1.0, HASTE])
@pytest.mark.parametrize("name", CONDITIONS)
def test_a_bad_link_does_not_lead_the_vehicle_astray(name: str, speedup: float) -> None:
    conditions, mean_m, max_m = CONDITIONS[name]
    run = follow(None, conditions, speedup=speedup)
    assert_returned(run, speedup)
    if speedup == 1.0:
        off_m = run.off_path_m()
        assert off_m.mean() < mean_m and off_m.max() < max_m, (off_m.mean(), off_m.max())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speedup", "silent_s", "off_m"), [(1.0, 1.0, 5.0), (1.0, 3.0, 5.0), (1.0, 6.0, 5.0), (HASTE, 3.0, 10.0)]
)
def test_a_silence_stops_the_vehicle_and_it_goes_on_without_a_rush(
    speedup: float, silent_s: float, off_m: float
) -> None:
    cut = when_following(lambda link: link.cut(silent_s), 160)
    run = follow(None, None, cut, speedup=speedup)
    assert_returned(run, speedup)
    assert run.off_path_m().max() < off_m
    lost = [type(event) for event in run.link_events]
    assert lost == ([LinkLost, LinkRestored] if silent_s > 4 else [])


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["approach", "following"])
def test_a_link_that_is_cut_for_ever_ends_the_program(moment: str) -> None:
    run = follow(None, None, on_the_way(cut) if moment == "approach" else when_following(cut))
    assert run.wall_s < MAX_WALL_S
    assert "no data for" in (run.line or "")
    assert "link to the vehicle lost" in (run.line or "")
    assert not run.rtl_confirmed
    assert (run.record is None) == (moment == "approach")


def cut(link: FaultLink) -> None:
    link.cut(FOREVER_S)


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["approach", "following"])
def test_a_connection_that_is_closed_is_opened_again(moment: str) -> None:
    closed = on_the_way(FaultLink.disconnect), when_following(FaultLink.disconnect)
    run = follow(None, None, closed[moment == "following"], speedup=HASTE)
    assert_returned(run, HASTE)


# Our own process


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speedup", "stall_s", "off_m"), [(1.0, 1.0, 1.5), (1.0, 3.0, 5.0), (HASTE, 3.0, 10.0)]
)
def test_a_stall_of_the_program_is_made_good(speedup: float, stall_s: float, off_m: float) -> None:
    stalls = iter([stall_s])

    def stall(event: Event) -> None:
        if isinstance(event, Following) and event.recording_s > 12.0:
            time.sleep(next(stalls, 0.0))

    run = follow(speedup=speedup, listener=stall)
    assert_returned(run, speedup)
    assert run.off_path_m().max() < off_m


# The autopilot, the pilot, and other stations


PILOTS = {
    "take-off": ("takeoff", 3.0),
    "approach": ("takeoff", 7.0),
    "following": ("target", 10.0),
}


@pytest.mark.parametrize("speedup", [pytest.param(1.0, marks=pytest.mark.slow), HASTE])
@pytest.mark.parametrize("moment", PILOTS)
def test_a_pilot_who_takes_over_is_not_overruled(moment: str, speedup: float) -> None:
    trigger, after_s = PILOTS[moment]
    run = follow(at(trigger, after_s, sim.PilotMode(LOITER)), speedup=speedup)
    assert "LOITER by the pilot" in (run.line or "")
    assert_left_alone(run, LOITER, speedup)
    assert (run.record is not None) == (moment == "following")


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["takeoff", "target"])
def test_a_mode_that_was_changed_and_changed_back_ends_the_stream(moment: str) -> None:
    """Whoever did it has the vehicle: it is neither followed on, nor sent home."""
    there, back = (
        ScriptedFault(moment, 7.0 + s, sim.PilotMode(mode)) for s, mode in ((0, LOITER), (1.5, GUIDED))
    )
    run = follow(Faults(script=(there, back)), speedup=2.0)
    assert "LOITER by the pilot" in (run.line or "")
    assert_left_alone(run, LOITER)


@pytest.mark.slow
@pytest.mark.parametrize(("mode", "name"), [(RTL, "RTL"), (LAND, "LAND")])
def test_a_failsafe_is_accepted(mode: CopterMode, name: str) -> None:
    run = follow(at("target", 8.0, sim.FailsafeMode(mode, "Radio Failsafe")), speedup=HASTE)
    assert f"changed to {name} by itself: Radio Failsafe" in (run.line or "")
    assert_left_alone(run, mode, HASTE)


@pytest.mark.slow
def test_a_battery_failsafe_is_accepted() -> None:
    drained = at("target", 3.0, sim.SetParameter("SIM_BATT_VOLTAGE", 9.0))
    run = follow(drained, duration_s=40.0, BATT_FS_LOW_ACT=2.0, BATT_LOW_VOLT=10.5)
    assert "changed to RTL by itself" in (run.line or "")
    assert "attery" in (run.line or "")
    assert_left_alone(run, RTL)


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["takeoff", "target"])
def test_a_reboot_ends_the_flight(moment: str) -> None:
    run = follow(at(moment, 7.0, sim.Reboot()), speedup=HASTE)
    assert run.wall_s < MAX_WALL_S
    assert "rebooted" in (run.line or "")


@pytest.mark.slow
def test_a_fence_that_drops_targets_ends_in_rtl() -> None:
    """ArduCopter drops targets outside its fence without a word."""
    fence = [ScriptedFault("target", 5.0, sim.SetParameter(*each)) for each in FENCE.items()]
    run = follow(Faults(script=tuple(fence)), duration_s=40.0, speedup=HASTE)
    assert run.wall_s < MAX_WALL_S
    assert run.record is not None
    assert run.record.ended in {"no progress", "off course"}
    assert "fence" in (run.line or "")
    assert run.rtl_confirmed
    assert_no_rush(run)


FENCE = {"FENCE_TYPE": 2.0, "FENCE_RADIUS": 45.0, "FENCE_ENABLE": 1.0}


def another_target(link: FaultLink) -> None:
    """Another station sends the vehicle 50 m aside, once."""
    link.send_as_another(
        dialect.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, dialect.MAV_FRAME_LOCAL_NED, 0b111111111000, 0, -50, -12, *(0.0,) * 8
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize(("times", "speedup"), [(1, HASTE), (1000, 10.0)])
def test_another_station_that_sends_targets(times: int, speedup: float) -> None:
    """One is made good by the next of ours; a stream may end the flight in RTL, for nobody took the mode."""
    run = follow(None, None, Trigger(nth_target(60), another_target, times), speedup=speedup)
    assert run.wall_s < MAX_WALL_S
    assert run.rtl_confirmed
    assert run.record is not None
    if times == 1:
        assert_returned(run, speedup)
    else:
        assert run.record.ended in {"off course", "no progress", "duration"}
        assert run.off_path_m().max() < 12.0


@pytest.mark.slow
def test_another_station_that_takes_the_mode_and_gives_it_back() -> None:
    changes = iter((LOITER, GUIDED))

    def change(link: FaultLink) -> None:
        mode = next(changes)
        message = dialect.MAVLink_command_long_message(1, 1, 176, 0, 1, mode, 0, 0, 0, 0, 0)
        link.send_as_another(message)

    back = Trigger(lambda m: is_in_mode(m, LOITER), change)
    run = follow(None, None, when_following(change), back)
    assert "LOITER by the pilot or another ground station" in (run.line or "")
    assert_left_alone(run, LOITER)


@pytest.mark.slow
def test_a_vehicle_that_disarms_is_not_followed() -> None:
    """Another station disarms it in the air, by force."""

    def disarm(link: FaultLink) -> None:
        link.send_as_another(dialect.MAVLink_command_long_message(1, 1, 400, 0, 0, 21196, 0, 0, 0, 0, 0))

    run = follow(None, None, when_following(disarm, 60), speedup=HASTE)
    assert run.record is not None
    assert run.record.ended in {"disarmed", "off course"}  # It falls off course before it tells.


@pytest.mark.slow
def test_arducopter_3_3_is_followed() -> None:
    """It has MAVLink 1, takes no acceleration, no heading in targets, and has a fixed timeout of 3 s."""
    run = follow(sim.old_copter(), speedup=2.0)
    assert_returned(run)
    assert run.off_path_m().mean() < 0.4
    assert all(m.type_mask & 0b111 << 6 for m in run.targets)

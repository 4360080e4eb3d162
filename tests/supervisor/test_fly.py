"""Whole flights under the supervisor: phases in order, deadlines, and the record."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest

from flight_replay import events
from flight_replay.events import Phase
from flight_replay.exceptions import PhaseTimeoutError, VehicleError
from flight_replay.mission.items import Mission, change_speed, waypoint
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle
from tests.helpers.supervised import Setup, fake_flight


def test_a_flight_requests_each_step_once_in_order() -> None:
    """GUIDED, mission verified, arm, take-off, mission verified again, AUTO, RTL."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    record = flight.fly()
    asked = [word for word in flight.vehicle.requested if word != "report"]
    assert asked == ["GUIDED", "verify", "arm", "takeoff", "verify", "AUTO", "RTL"]
    assert record.problem is None
    assert record.rtl_confirmed
    phases = [event.phase for event in flight.of(events.PhaseStarted)]
    assert phases == [Phase.PREARM, Phase.ARM, Phase.TAKEOFF, Phase.MISSION, Phase.RETURN]


def test_a_timed_flight_ends_after_its_duration() -> None:
    """60 s of AUTO in vehicle time; the waypoints reached by then are counted."""
    record = fake_flight(FakeVehicle(FakeClock(), points=40)).fly()
    assert record.ended == "duration"
    assert record.auto_s == pytest.approx(60, abs=0.3)
    assert record.waypoints_reached == 15
    assert [seq for seq, _ in record.reached] == list(range(1, 16))
    times_s = [time_s - record.auto_start_s for _, time_s in record.reached]
    assert times_s == pytest.approx([4.0 * n for n in range(1, 16)], abs=0.3)


def test_an_item_is_reached_between_two_positions() -> None:
    """Its report has no time: that of the position before it would be early by half of their distance."""
    record = fake_flight(FakeVehicle(FakeClock(), points=40)).fly()
    positions_s = record.flown.time_s
    for _, time_s in record.reached:
        before_s, next_s = positions_s[positions_s < time_s][-1], positions_s[positions_s > time_s][0]
        assert time_s == pytest.approx((before_s + next_s) / 2)


def test_waypoints_on_the_way_to_rtl_do_not_count() -> None:
    """The request comes late over a bad link: what is reached until then is not of the flown track."""
    vehicle, heard_s = FakeVehicle(FakeClock(), points=40), []
    obey = vehicle.request_mode

    def request_mode(mode: str) -> None:
        if mode == "RTL":
            heard_s.append(vehicle.time_s)
        if mode != "RTL" or vehicle.time_s > heard_s[0] + 12.0:
            obey(mode)

    vehicle.request_mode = request_mode  # type: ignore[method-assign]
    record = fake_flight(vehicle).fly()
    assert (record.ended, record.rtl_confirmed, record.waypoints_reached) == ("duration", True, 15)
    assert record.reached[-1][0] == 15
    assert record.flown.time_s[-1] - record.auto_start_s == pytest.approx(60, abs=0.3)


@pytest.mark.parametrize("speedup", [0.5, 1.0, 20.0])
def test_the_speed_of_the_vehicles_clock_changes_nothing(speedup: float) -> None:
    """A simulator whose clock runs faster or slower than wall-clock time flies the same 60 s."""
    record = fake_flight(FakeVehicle(FakeClock(), speedup=speedup, points=40)).fly()
    assert record.auto_s == pytest.approx(60, abs=2.5)
    assert record.problem is None


def test_a_timed_flight_ends_when_heading_for_the_final_waypoint() -> None:
    """As in DroneKit's example; the waypoint before the final one was reached."""
    record = fake_flight().fly()
    assert (record.ended, record.waypoints_reached) == ("final waypoint", 4)


def test_a_whole_flight_reaches_the_last_waypoint() -> None:
    """``duration_s=None`` flies until the last waypoint is reached."""
    record = fake_flight(duration_s=None).fly()
    assert (record.ended, record.waypoints_reached, record.problem) == ("mission complete", 5, None)
    assert record.auto_s == pytest.approx(20, abs=1.5)


def test_waypoints_reached_are_known_from_the_current_item_too() -> None:
    """If every MISSION_ITEM_REACHED is lost, MISSION_CURRENT shows them."""
    vehicle = FakeVehicle(FakeClock(), reports_reached=False)
    assert fake_flight(vehicle, duration_s=None).fly().waypoints_reached == 5


def test_the_flown_track_has_the_positions_in_auto() -> None:
    """It starts and ends with AUTO, and moves north."""
    record = fake_flight().fly()
    assert record.flown.time_s[0] >= record.auto_start_s
    assert record.flown.time_s[-1] - record.auto_start_s == pytest.approx(record.auto_s, abs=0.2)
    assert record.flown.lat_deg[-1] > record.flown.lat_deg[0]


def test_takeoff_is_complete_at_95_percent() -> None:
    """The climb to 28.5 m is emitted once a second."""
    flight = fake_flight()
    flight.fly()
    climbs = flight.of(events.Climbing)
    assert 10 <= len(climbs) <= 14
    assert {event.threshold_m for event in climbs} == {28.5}
    assert flight.of(events.TargetAltitudeReached) == [events.TargetAltitudeReached(30.0)]


def test_land_waits_until_the_vehicle_has_landed() -> None:
    """Until it has disarmed on the ground."""
    flight = fake_flight(land=True)
    assert flight.fly().landed
    assert not flight.vehicle.armed


def test_slow_arming_is_requested_once() -> None:
    """ArduCopter 3.3 takes 3 s to arm, and starts over at a second request."""
    flight = fake_flight(FakeVehicle(FakeClock(), arm_delay_s=3.0))
    flight.fly()
    assert flight.vehicle.requested.count("arm") == 1


def never_ready(vehicle: FakeVehicle) -> None:
    vehicle.ready_after_s = 1e9
    vehicle.schedule.append((5.0, lambda: vehicle.send_text("PreArm: Compass not calibrated")))


def arming_refused(vehicle: FakeVehicle) -> None:
    vehicle.refuse_arm = "Arm: Throttle too high"


def guided_refused(vehicle: FakeVehicle) -> None:
    vehicle.refuse_mode = frozenset({"GUIDED"})


def auto_refused(vehicle: FakeVehicle) -> None:
    vehicle.refuse_mode = frozenset({"AUTO"})


def no_climb(vehicle: FakeVehicle) -> None:
    vehicle.climbs = False


def wrong_mission(vehicle: FakeVehicle) -> None:
    vehicle.verified = False


FAILURES: list[tuple[Setup, type[Exception], str, bool]] = [
    (never_ready, PhaseTimeoutError, "Compass not calibrated", False),
    (arming_refused, PhaseTimeoutError, "Throttle too high", False),
    (guided_refused, PhaseTimeoutError, "did not change to GUIDED", False),
    (auto_refused, PhaseTimeoutError, 'change to AUTO in 15 s: it says "FAILED"', True),
    (no_climb, PhaseTimeoutError, "did not climb above 0.0 m in 25 s", True),
    (wrong_mission, VehicleError, "another ground station changed it", False),
]


@pytest.mark.parametrize(
    ("setup", "kind", "words", "armed"), FAILURES, ids=lambda x: getattr(x, "__name__", None)
)
def test_a_phase_that_fails_names_the_reason(
    setup: Setup, kind: type[Exception], words: str, armed: bool
) -> None:
    """Each deadline ends in one sentence with the autopilot's reason; RTL is commanded if it is armed."""
    flight = fake_flight()
    setup(flight.vehicle)
    with pytest.raises(kind, match=words):
        flight.fly()
    assert ("RTL" in flight.vehicle.requested) is armed
    assert flight.of(events.ReturnCommanded) == ([events.ReturnCommanded(True)] if armed else [])
    assert flight.wall_s < 250


def test_a_vehicle_that_stops_on_its_way_flies_rtl() -> None:
    """No progress for a minute ends a flight that has no duration."""
    flight = fake_flight(FakeVehicle(FakeClock(), item_s=1e9), duration_s=None)
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("no progress", True)


def test_a_hold_is_not_a_standstill() -> None:
    """A hold of two minutes does not end the flight; an item without a position has no distance."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=3, item_s=100.0), duration_s=None)
    items = (waypoint(47.0, 8.0, 30.0, hold_s=120), change_speed(3.0), waypoint(47.001, 8.0, 30.0))
    flight.fly_instead(Mission(items))
    assert flight.fly().ended == "mission complete"
    distances = {event.seq: event.distance_m for event in flight.of(events.DistanceToWaypoint)}
    assert distances[2] is None


def test_a_landing_that_does_not_end_is_a_problem() -> None:
    """A vehicle that hovers on its way down leaves the record with a problem."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40), land=True)
    move = flight.vehicle.move
    flight.vehicle.move = lambda step_s: None if flight.vehicle.mode == "RTL" else move(step_s)  # type: ignore[method-assign]
    record = flight.fly()
    assert (record.rtl_confirmed, record.landed) == (True, False)
    assert "does not come home" in (record.problem or "")


def test_a_landing_is_awaited_as_long_as_rtl_waits_over_home() -> None:
    """RTL_LOIT_TIME of 100 s, with 60 s for all else that does not move."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40), land=True, rtl_loiter_s=100.0)
    move = flight.vehicle.move
    waits_until_s = 0.0

    def wait(step_s: float) -> None:
        nonlocal waits_until_s
        if flight.vehicle.mode == "RTL":
            waits_until_s = waits_until_s or flight.vehicle.time_s + 140.0
        if flight.vehicle.time_s > waits_until_s:
            move(step_s)

    flight.vehicle.move = wait  # type: ignore[method-assign]
    record = flight.fly()
    assert (record.landed, record.problem) == (True, None)


@pytest.mark.parametrize(
    ("mode", "reason"), [("AUTO", "stopped on its way to item 1"), ("GUIDED", "did not climb above 0.0 m")]
)
def test_why_the_vehicle_is_sent_home_is_told_before_it_is(mode: str, reason: str) -> None:
    """Not only when the program ends, which with a landing is minutes later."""
    vehicle = FakeVehicle(FakeClock(), item_s=1e9, climbs=mode == "AUTO")
    flight = fake_flight(vehicle, duration_s=None)
    with suppress(VehicleError):
        flight.fly()
    kinds = [event for event in flight.events if isinstance(event, events.Notice | events.PhaseStarted)]
    told, home = kinds[-2:]
    assert isinstance(told, events.Notice)
    assert told.warning
    assert reason in told.text
    assert home == events.PhaseStarted(events.Phase.RETURN)


def test_the_flown_track_has_the_headings_that_the_vehicle_told() -> None:
    """A heading is kept with its position; one that the vehicle does not know is not a number."""
    record = fake_flight(FakeVehicle(FakeClock(), heading_deg=271.5)).fly()
    assert len(record.flown) > 10
    assert set(record.flown.heading_deg) == {271.5}
    assert np.isnan(fake_flight().fly().flown.heading_deg).all()


def test_a_flight_is_over_when_rtl_is_confirmed() -> None:
    """Unless asked to, nobody waits for the landing."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    record = flight.fly()
    assert (record.rtl_confirmed, record.landed) == (True, False)
    assert flight.vehicle.altitude_m > 20.0


@pytest.mark.parametrize(("limit_m", "landed"), [(0.0, False), (1000.0, True)])
def test_a_rally_point_may_be_far_away(limit_m: float, landed: bool) -> None:
    """RTL goes to it, by the vehicle's RALLY_LIMIT_KM; without rally points it is the wind."""
    vehicle = FakeVehicle(FakeClock(), points=40, rtl_north_m=700.0)
    record = fake_flight(vehicle, land=True, rally_limit_m=limit_m).fly()
    assert record.landed == landed
    assert ("driven away from home" in (record.problem or "")) != landed


def test_a_clock_that_jumps_ahead_is_not_the_end_of_the_duration() -> None:
    """The flight ends, because nothing tells how long it has lasted, and that is a problem."""
    vehicle = FakeVehicle(FakeClock(), points=4000)

    def jump() -> None:
        time_s, wall_s = vehicle.since
        vehicle.since = time_s + 600.0, wall_s

    vehicle.schedule.append((30.0, jump))
    record = fake_flight(vehicle).fly()
    assert (record.ended, record.rtl_confirmed) == ("no progress", True)
    assert (record.problem or "").startswith("the vehicle's clock jumped ahead by 600 s")

"""AUTO and the return: progress, its end, RTL and the landing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from flight_replay import events
from flight_replay.events import DistanceToWaypoint, Phase, VehicleState, Waiting
from flight_replay.mission.items import Mission, change_speed, waypoint
from flight_replay.supervisor import Deadlines, FlightRecord, Plan
from flight_replay.supervisor.mission_phases import distance_to_item_m
from flight_replay.supervisor.vehicle_interface import (
    Heartbeat,
    MissionCurrent,
    MissionItemReached,
    Rebooted,
    Report,
    Request,
    RequestAck,
)
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle, route
from tests.helpers.supervised import FakeFlight, fake_flight


@pytest.mark.parametrize(("item_s", "ended"), [(1100.0, "duration"), (1400.0, "no progress")])
def test_half_a_metre_a_minute_is_progress(item_s: float, ended: str) -> None:
    """10 m between waypoints in 1100 s are 0.5 m in 55 s; in 1400 s they are 0.5 m in 70 s."""
    flight = fake_flight(FakeVehicle(FakeClock(), item_s=item_s), duration_s=200.0)
    record = flight.fly()
    assert record.ended == ended
    assert record.problem in (None, "the vehicle stopped on its way to item 1; find out why")


def test_a_long_descent_is_progress() -> None:
    """On the spot, at 0.3 m/s, to a waypoint that is reached after 100 s."""
    vehicle = FakeVehicle(FakeClock(), item_s=1e9)
    flight = fake_flight(vehicle, duration_s=100.0, takeoff_altitude_m=50.0)
    move = vehicle.move

    def sink(step_s: float) -> None:
        move(step_s)
        if vehicle.mode == "AUTO":
            vehicle.altitude_m -= 0.3 * step_s

    vehicle.move = sink  # type: ignore[method-assign]
    assert flight.fly().ended == "duration"


def test_a_vehicle_that_is_driven_away_is_sent_home() -> None:
    """It moves, but not to where it has to go; on the way home it is told that it does not come there."""
    vehicle = FakeVehicle(FakeClock(), item_s=1e9)
    flight = fake_flight(vehicle, duration_s=None, land=True)
    move = vehicle.move

    def drift(step_s: float) -> None:
        move(step_s)
        if vehicle.mode in ("AUTO", "RTL"):
            vehicle.place_m = vehicle.place_m - np.array([2.0 * step_s, 0.0])
        if vehicle.mode == "RTL":
            vehicle.armed, vehicle.altitude_m = True, 30.0

    vehicle.move = drift  # type: ignore[method-assign]
    record = flight.fly()
    assert (record.ended, record.landed) == ("no progress", False)
    assert record.problem is not None
    home, _, before = record.problem.partition("; before that ")
    assert home.startswith("the vehicle is driven away from home, 52")
    assert before.startswith("the vehicle is driven away from item 1, 13")
    assert flight.wall_s < 400.0
    waits = [event.reason for event in flight.of(Waiting) if event.phase is Phase.RETURN]
    assert waits[-1].endswith(" m above home, 523 m away")


@pytest.mark.parametrize("by_m", [0.0, 15.0], ids=["up and down", "to and fro"])
def test_a_vehicle_that_does_not_come_home_though_it_moves_is_told(by_m: float) -> None:
    """Its accelerometers failed: a real 4.6 hopped about home for as long as it was watched."""
    vehicle = FakeVehicle(FakeClock())
    flight = fake_flight(vehicle, duration_s=5.0, land=True)
    move = vehicle.move

    def hop(step_s: float) -> None:
        move(step_s)
        if vehicle.mode == "RTL":
            vehicle.armed, vehicle.altitude_m = True, 5.0 + 2.0 * float(np.sin(vehicle.time_s))
            vehicle.place_m = np.array([by_m * np.sin(vehicle.time_s), 0.0])

    vehicle.move = hop  # type: ignore[method-assign]
    record = flight.fly()
    assert (record.ended, record.landed) == ("duration", False)
    assert record.problem is not None
    assert "the vehicle did" in record.problem or "does not come home" in record.problem
    assert flight.wall_s < 200.0


def flown_without_the_last_report(vehicle: FakeVehicle, mission: Mission) -> FlightRecord:
    """The whole of a mission, on firmware that does not tell that it is complete; one packet is lost."""
    reports = vehicle.reports

    def received(timeout_s: float) -> list[Report]:
        return [
            MissionCurrent(report.seq) if isinstance(report, MissionCurrent) else report
            for report in reports(timeout_s)
            if report != MissionItemReached(vehicle.points)
        ]

    vehicle.reports = received  # type: ignore[method-assign]
    flight = fake_flight(vehicle, duration_s=None)
    flight.fly_instead(mission)
    return flight.fly()


@pytest.mark.parametrize("hold_s", [0.0, 40.0])
def test_a_mission_is_complete_though_the_report_of_its_last_item_is_lost(hold_s: float) -> None:
    """The vehicle rests at the last waypoint, for longer than it has to hold there."""
    items = (*route(4).items, waypoint(47.0 + 9e-5 * 5, 8.0, 30.0, hold_s=hold_s))
    record = flown_without_the_last_report(FakeVehicle(FakeClock(), points=5), Mission(items))
    assert (record.ended, record.problem, record.waypoints_reached) == ("mission complete", None, 5)
    assert record.auto_s == pytest.approx(20.0 + hold_s + 10.0, abs=2.0)


@pytest.mark.parametrize(
    ("rests_at_s", "alt_m"),
    [(7.9, 30.0), (18.0, 30.0), (20.0, 40.0)],
    ids=["where the last waypoint is, flying to another", "5 m before it", "10 m below it"],
)
def test_a_rest_elsewhere_does_not_complete_a_mission(rests_at_s: float, alt_m: float) -> None:
    """The vehicle stops so many seconds after AUTO began; the last waypoint may be where another is."""
    vehicle = FakeVehicle(FakeClock(), points=5)
    move = vehicle.move

    def stop(step_s: float) -> None:
        move(step_s)
        vehicle.auto_s = min(vehicle.auto_s, rests_at_s)

    vehicle.move = stop  # type: ignore[method-assign]
    last = waypoint(47.0 + 9e-5 * (2 if rests_at_s < 10.0 else 5), 8.0, alt_m)
    record = flown_without_the_last_report(vehicle, Mission((*route(4).items, last)))
    assert (record.ended, record.rtl_confirmed) == ("no progress", True)


def test_a_new_item_is_progress_even_without_a_position() -> None:
    """Five commands that take 50 s each, and a waypoint."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=6, item_s=50.0), duration_s=None)
    items = (*[change_speed(3.0)] * 5, waypoint(47.001, 8.0, 30.0))
    flight.fly_instead(Mission(items))
    assert flight.fly().ended == "mission complete"


def test_the_distance_is_emitted_once_a_second() -> None:
    """From the first item on; 10 m between items, flown in 4 s each."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.fly()
    distances = flight.of(DistanceToWaypoint)
    assert 50 <= len(distances) <= 62
    assert min(event.seq for event in distances) == 1
    assert {event.waypoints for event in distances} == {40}
    of_item_2 = [event.distance_m or 0.0 for event in distances if event.seq == 2]
    assert max(of_item_2) < 10.1
    assert min(of_item_2) < 2.6


def test_waypoints_are_counted_as_waypoints() -> None:
    """Not as items, of which speed changes are some."""
    items = (change_speed(3.0), waypoint(47.0, 8.0, 30.0), change_speed(2.0), waypoint(47.001, 8.0, 30.0))
    plan = Plan(mission=Mission(items))
    assert [plan.waypoint_at(seq) for seq in range(6)] == [(1, 2), (1, 2), (1, 2), (2, 2), (2, 2), (2, 2)]


@pytest.mark.parametrize(("seq", "distance_m"), [(0, None), (1, 10.0), (5, 50.0), (6, None)])
def test_the_distance_is_that_to_the_current_item(seq: int, distance_m: float | None) -> None:
    """None before the first item, and beyond the last one; None without a position."""
    clock = FakeClock()
    monitor = VehicleMonitor(FakeVehicle(clock), clock, events.ignore, Deadlines())
    plan = Plan(mission=route(5))
    monitor.mission = MissionCurrent(seq)
    assert distance_to_item_m(monitor, plan) is None
    monitor.state = VehicleState(1.0, 47.0, 8.0, 30.0, (0, 0, 0), None, "AUTO", True)
    assert distance_to_item_m(monitor, plan) == (distance_m and pytest.approx(distance_m, abs=0.1))


def test_a_mode_change_at_the_end_of_the_duration_is_the_pilots() -> None:
    """The next heartbeat is waited for before RTL is commanded."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    request_mode = vehicle.request_mode

    def take_over() -> None:
        vehicle.mode = "LOITER"
        vehicle.queue.append(Heartbeat("LOITER", True))

    def request(mode: str) -> None:
        request_mode(mode)
        if mode == "AUTO":
            vehicle.schedule.append((vehicle.clock.now_s - vehicle.began_s + 59.8, take_over))

    vehicle.request_mode = request  # type: ignore[method-assign]
    record = fake_flight(vehicle).fly()
    assert record.ended == "pilot"
    assert "RTL" not in vehicle.requested


def _fallen(alt_m: float, for_s: float = 60.0, points: int = 40) -> tuple[FakeFlight, FlightRecord]:
    """A flight of a vehicle that is at a height, 10 s after AUTO began, for some seconds."""
    vehicle = FakeVehicle(FakeClock(), points=points)
    flight = fake_flight(vehicle)
    vehicle.schedule += [
        (30.0, lambda: setattr(vehicle, "altitude_m", alt_m)),
        (30.0, lambda: vehicle.send_text("Potential Thrust Loss (1)", 0)),
        (30.0 + for_s, lambda: setattr(vehicle, "altitude_m", 30.0)),
    ]
    return flight, flight.fly()


def test_a_vehicle_that_fell_and_stays_armed_does_not_end_as_asked() -> None:
    """Its motors run on the ground, and the one who goes there has to know."""
    flight, record = _fallen(0.2)
    assert (record.ended, record.rtl_confirmed) == ("off course", True)
    assert record.problem is not None
    assert 'it is 0.2 m above home, and was to be at 30 m or higher: it says "Potential' in record.problem
    assert "keep away until it is disarmed" in record.problem
    assert flight.wall_s < 40.0


@pytest.mark.parametrize(("alt_m", "for_s"), [(15.0, 60.0), (2.0, 1.0)], ids=["half as high", "for a moment"])
def test_what_is_not_a_fall_goes_on(alt_m: float, for_s: float) -> None:
    """Heights step for a moment where the estimator changes its mind."""
    _, record = _fallen(alt_m, for_s)
    assert (record.ended, record.problem) == ("duration", None)


def test_a_vehicle_that_somebody_else_lands_has_not_fallen() -> None:
    """Only one heartbeat showed LAND: whoever lands it has it."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def land() -> None:
        vehicle.mode, vehicle.altitude_m = "LAND", 2.0
        vehicle.queue.append(Heartbeat("LAND", True))
        vehicle.heartbeat_s = vehicle.time_s + 4.0

    vehicle.schedule.append((30.0, land))
    record = fake_flight(vehicle).fly()
    assert (record.ended, "RTL" in vehicle.requested) == ("failsafe", False)


def test_why_it_cannot_be_armed_again_is_not_why_a_vehicle_disarmed() -> None:
    vehicle = FakeVehicle(FakeClock(), points=40)

    def terminate() -> None:
        vehicle.send_text("Battery Failsafe", 4)
        vehicle.armed = False
        vehicle.send_text("PreArm: Battery 1 low voltage failsafe", 2)

    vehicle.schedule.append((30.0, terminate))
    assert 'it says "Battery Failsafe"' in str(fake_flight(vehicle).fly().problem)


def test_disarming_without_a_status_text_has_no_reason() -> None:
    """The message says so by leaving it out."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    vehicle.schedule.append((30.0, lambda: setattr(vehicle, "armed", False)))
    record = fake_flight(vehicle).fly()
    assert record.problem == "the vehicle disarmed in flight; find out why before flying again"


@pytest.mark.parametrize(("acked", "fewest", "most"), [(True, 22, 28), (False, 100, 200)])
def test_rtl_is_requested_until_a_heartbeat_confirms_it(acked: bool, fewest: int, most: int) -> None:
    """Every 1.2 s once it is accepted, as often as an ack takes while it is not; for 30 s."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    request_mode = vehicle.request_mode

    def ignore_rtl(mode: str) -> None:
        if mode != "RTL":
            request_mode(mode)
            return
        vehicle.requested.append(mode)
        if acked:
            vehicle.queue.append(RequestAck(Request.MODE, True))

    vehicle.request_mode = ignore_rtl  # type: ignore[method-assign]
    flight = fake_flight(vehicle)
    record = flight.fly()
    assert fewest <= vehicle.requested.count("RTL") <= most
    assert record.problem == (
        "the vehicle did not confirm RTL; take control with the transmitter or another ground station"
    )


def test_an_unexpected_mode_that_is_not_repeated_delays_rtl_by_two_seconds() -> None:
    """One heartbeat of another mode, and then positions only: RTL is not held back for ever."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    times_s: list[float] = []
    request_mode = vehicle.request_mode

    def interrupt() -> None:
        raise KeyboardInterrupt

    def doubt() -> None:
        vehicle.queue.append(Heartbeat("LOITER", True))
        vehicle.heartbeat_s = vehicle.time_s + 5.0
        vehicle.schedule.append((30.1, interrupt))

    def request(mode: str) -> None:
        if mode == "RTL":
            times_s.append(vehicle.clock.now_s - vehicle.began_s)
        request_mode(mode)

    vehicle.request_mode = request  # type: ignore[method-assign]
    vehicle.schedule.append((30.0, doubt))
    with pytest.raises(KeyboardInterrupt):
        fake_flight(vehicle).fly()
    assert times_s[0] == pytest.approx(32.0, abs=0.25)


def test_a_long_landing_is_awaited_while_the_vehicle_moves() -> None:
    """From 200 m at 2.5 m/s it takes 80 s, longer than 60 s without progress would."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40), land=True, takeoff_altitude_m=200.0)
    record = flight.fly()
    assert (record.landed, record.problem) == (True, None)
    waits = [event.reason for event in flight.of(Waiting) if event.phase is Phase.RETURN]
    assert 65 <= len(waits) <= 80
    assert waits[-1].endswith(" m above home, 150 m away")


def test_a_vehicle_that_the_wind_drives_off_slowly_on_its_way_home_is_told() -> None:
    """At 0.1 m/s it would take an hour to be far away."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def drift(step_s: float) -> None:
        vehicle.place_m = vehicle.place_m + np.array([0.1 * step_s, 0.0])

    vehicle.land = drift  # type: ignore[method-assign]
    record = fake_flight(vehicle, land=True, duration_s=20.0).fly()
    assert (record.ended, record.rtl_confirmed, record.landed) == ("duration", True, False)
    assert "does not come home, 57 m away and 30 m above home; check the wind" in str(record.problem)


@pytest.mark.parametrize(("duration_s", "away"), [(1.0, ""), (20.0, "50 m away from home")])
def test_land_on_the_way_home_is_a_landing_too(duration_s: float, away: str) -> None:
    """A failsafe may land the vehicle sooner; elsewhere than asked is no success."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def land() -> None:
        vehicle.mode = "LAND"
        vehicle.send_text("Battery Failsafe")

    on_the_way_home(vehicle, 3.0, (0.0, land))
    record = fake_flight(vehicle, land=True, duration_s=duration_s).fly()
    assert (record.ended, record.rtl_confirmed, record.landed) == ("duration", True, True)
    assert bool(record.problem) == bool(away)
    assert not away or (away in str(record.problem) and 'says "Battery Failsafe"' in str(record.problem))


@pytest.mark.parametrize("text", ["EKF Failsafe: changed to LAND Mode", ""], ids=["failsafe", "unknown"])
def test_land_on_the_way_home_is_told_with_its_reason(text: str) -> None:
    """Which follows the heartbeat with the mode."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    flight = fake_flight(vehicle, land=True, duration_s=10.0)
    request_mode = vehicle.request_mode

    def land() -> None:
        vehicle.mode, vehicle.heartbeat_s = "LAND", 0.0
        now_s = vehicle.clock.now_s - vehicle.began_s
        if text:
            vehicle.schedule.append((now_s + 0.3, lambda: vehicle.send_text(text, 2)))

    def request(mode: str) -> None:
        request_mode(mode)
        if mode == "RTL":
            vehicle.schedule.append((vehicle.clock.now_s - vehicle.began_s + 3.0, land))

    vehicle.request_mode = request  # type: ignore[method-assign]
    assert flight.fly().landed
    told = [notice.text for notice in flight.of(events.Notice)]
    why = f'it says "{text}"' if text else "the pilot, another ground station or a failsafe changed it"
    assert [why in each for each in told] == [True]


def on_the_way_home(vehicle: FakeVehicle, after_s: float, *actions: tuple[float, Callable[[], None]]) -> None:
    """Schedule actions from so many seconds after RTL was requested on; each has its own delay."""
    request_mode = vehicle.request_mode

    def request(mode: str) -> None:
        request_mode(mode)
        if mode == "RTL":
            now_s = vehicle.clock.now_s - vehicle.began_s + after_s
            vehicle.schedule += [(now_s + delay_s, action) for delay_s, action in actions]

    vehicle.request_mode = request  # type: ignore[method-assign]


@pytest.mark.parametrize("after_s", [1.0, 5.0, 9.3, 10.5])
def test_motors_that_stop_on_the_way_home_are_no_landing(after_s: float) -> None:
    """From 30 m down to 3 m, in a descent: it ends as AUTO does for the same."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def kill() -> None:
        vehicle.armed = False
        vehicle.send_text("Crash: Disarming")

    on_the_way_home(vehicle, after_s, (0.0, kill))
    record = fake_flight(vehicle, land=True).fly()
    assert (record.ended, record.rtl_confirmed, record.landed) == ("disarmed", True, False)
    assert 'disarmed in flight: it says "Crash: Disarming"' in (record.problem or "")


def test_a_reboot_on_the_way_home_is_no_landing() -> None:
    """Its heartbeats look disarmed at once, and its clock comes later."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def reboot() -> None:
        vehicle.mode, vehicle.armed, vehicle.reports_clock = "STABILIZE", False, False

    on_the_way_home(vehicle, 3.0, (0.0, reboot), (4.0, lambda: vehicle.queue.append(Rebooted())))
    record = fake_flight(vehicle, land=True).fly()
    assert (record.ended, record.rtl_confirmed, record.landed) == ("reboot", True, False)
    assert "rebooted" in (record.problem or "")


@pytest.mark.parametrize("ground_m", [-5.0, 0.0, 6.0])
def test_the_ground_need_not_be_as_high_as_home(ground_m: float) -> None:
    """A pilot lands it on a slope: that it rests there tells, not its height."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    vehicle.ground_m = ground_m
    on_the_way_home(vehicle, 3.0, (0.0, lambda: setattr(vehicle, "mode", "LAND")))
    record = fake_flight(vehicle, land=True, duration_s=1.0).fly()
    assert (record.landed, record.problem) == (True, None)


def test_a_disarming_that_nobody_saw_is_no_landing() -> None:
    """The link was down meanwhile; what came of the vehicle is not known."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def silent() -> None:
        vehicle.silent = True

    on_the_way_home(vehicle, 3.0, (0.0, silent), (20.0, lambda: setattr(vehicle, "silent", False)))
    record = fake_flight(vehicle, land=True).fly()
    assert (record.ended, record.landed) == ("disarmed", False)
    assert "no position tells whether it had landed" in (record.problem or "")

"""Flights that end early: Ctrl-C, lost links, reboots, disarming, missions changed by another station."""

from __future__ import annotations

import pytest

from flight_replay import events
from flight_replay.events import Event
from flight_replay.exceptions import LinkFaultError, PhaseTimeoutError, VehicleError
from flight_replay.supervisor import Deadlines, FlightInterrupted, Plan, fly
from flight_replay.supervisor.vehicle_interface import MissionCurrent, Rebooted
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle, route
from tests.helpers.supervised import fake_flight


@pytest.mark.parametrize("when_s", [6.0, 12.0, 20.0, 30.0])
def test_ctrl_c_commands_rtl(when_s: float) -> None:
    """Ctrl-C in the air commands RTL, emits that it is confirmed, and is raised again."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))

    def interrupt() -> None:
        raise KeyboardInterrupt

    flight.vehicle.schedule.append((when_s, interrupt))
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert flight.vehicle.mode == "RTL"
    assert flight.of(events.ReturnCommanded) == [events.ReturnCommanded(True)]
    assert flight.wall_s < when_s + 10


def interrupted_flight(vehicle: FakeVehicle, when_s: float, **plan: object) -> FlightInterrupted:
    """What a flight raises that is interrupted then."""

    def interrupt() -> None:
        raise KeyboardInterrupt

    vehicle.schedule.append((when_s, interrupt))
    with pytest.raises(FlightInterrupted) as interrupted:
        fake_flight(vehicle, **plan).fly()
    return interrupted.value


def test_ctrl_c_keeps_the_record_of_the_part_flown() -> None:
    """Up to the interrupt, not what was flown until the vehicle heard of RTL."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    obeys_from_s, obey = vehicle.clock.now_s + 36.0, vehicle.request_mode

    def request_mode(mode: str) -> None:
        if mode != "RTL" or vehicle.clock.now_s > obeys_from_s:
            obey(mode)

    vehicle.request_mode = request_mode  # type: ignore[method-assign]
    record = interrupted_flight(vehicle, 30.0).record
    assert (record.ended, record.problem) == ("interrupted", "the flight was interrupted")
    assert record.rtl_confirmed
    assert record.waypoints_reached == len(record.reached) > 0
    assert record.flown.time_s[-1] == pytest.approx(record.auto_start_s + record.auto_s, abs=0.3)
    assert record.flown.time_s[-1] < vehicle.time_s - 5.0


def test_ctrl_c_on_the_way_home_keeps_the_whole_record() -> None:
    """The 10 s in AUTO were over when it came."""
    record = interrupted_flight(FakeVehicle(FakeClock(), points=40), 32.0, duration_s=10.0, land=True).record
    assert (record.ended, record.rtl_confirmed, record.landed) == ("interrupted", True, False)
    assert record.auto_s == pytest.approx(10.0, abs=0.3)


def test_an_interrupt_before_arming_commands_nothing() -> None:
    """The vehicle is not armed, so RTL is not needed."""
    flight = fake_flight()

    def interrupt() -> None:
        raise KeyboardInterrupt

    flight.vehicle.schedule.append((1.0, interrupt))
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert "RTL" not in flight.vehicle.requested


def test_a_restored_link_continues_the_flight() -> None:
    """A silence of 12 s is emitted within 5 s, and the flight ends as planned."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule += [
        (30.0, lambda: setattr(flight.vehicle, "silent", True)),
        (42.0, lambda: setattr(flight.vehicle, "silent", False)),
    ]
    record = flight.fly()
    assert (record.ended, record.problem) == ("duration", None)
    (lost,), (back,) = flight.of(events.LinkLost), flight.of(events.LinkRestored)
    assert lost.silent_s < 5 < back.silent_s


def test_a_link_that_stays_lost_ends_the_flight() -> None:
    """RTL is still requested, and the record says that the link is lost."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((30.0, lambda: setattr(flight.vehicle, "silent", True)))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("link lost", False)
    assert record.waypoints_reached > 0
    assert flight.vehicle.requested[-1] == "RTL"
    assert flight.wall_s < 30 + 30 + 10


def test_a_link_that_stays_lost_in_the_climb_ends_the_flight() -> None:
    """RTL is requested all the same: the vehicle may hear what we do not."""
    flight = fake_flight(FakeVehicle(FakeClock()))
    request_takeoff = flight.vehicle.request_takeoff

    def take_off(altitude_m: float) -> None:
        request_takeoff(altitude_m)
        flight.vehicle.silent = True

    flight.vehicle.request_takeoff = take_off  # type: ignore[method-assign]
    with pytest.raises(VehicleError, match="link to the vehicle lost"):
        flight.fly()
    assert flight.vehicle.requested[-1] == "RTL"


def test_a_reboot_in_the_air_ends_the_flight() -> None:
    """RTL is requested of the rebooted autopilot."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((30.0, lambda: flight.vehicle.queue.append(Rebooted())))
    record = flight.fly()
    assert record.ended == "reboot"
    assert "RTL" in flight.vehicle.requested


def test_a_reboot_on_the_ground_is_an_error() -> None:
    """Before arming, nothing is commanded."""
    flight = fake_flight()
    flight.vehicle.schedule.append((2.0, lambda: flight.vehicle.queue.append(Rebooted())))
    with pytest.raises(VehicleError, match="rebooted"):
        flight.fly()
    assert "RTL" not in flight.vehicle.requested


def test_a_mission_that_changes_in_flight_ends_the_flight() -> None:
    """Another number of items on board than at the start ends AUTO with RTL."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((30.0, lambda: flight.vehicle.queue.append(MissionCurrent(3, 7))))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("mission changed", True)


def test_a_mission_uploaded_in_flight_ends_the_flight() -> None:
    """With the same number of items too: the status text of the upload shows it."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((2.0, lambda: flight.vehicle.send_text("Flight plan received", 6)))
    flight.vehicle.schedule.append((30.0, lambda: flight.vehicle.send_text("Flight plan received", 6)))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("mission changed", True)
    assert 5 < record.auto_s < 30


def test_rtl_that_is_refused_is_a_problem() -> None:
    """A vehicle that does not confirm RTL leaves the record with a problem."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40, refuse_mode=frozenset({"RTL"})))
    record = flight.fly()
    assert not record.rtl_confirmed
    assert "did not confirm RTL" in (record.problem or "")


def test_a_wait_ends_if_the_vehicles_clock_stands_still() -> None:
    """By wall-clock time, after three times its limit."""
    flight = fake_flight(FakeVehicle(FakeClock(), reports_clock=False), deadlines=Deadlines(prearm_s=20))
    with pytest.raises(PhaseTimeoutError, match="not ready to arm in 20 s"):
        flight.fly()
    assert flight.wall_s < 70


def test_a_listener_that_fails_does_not_disturb_the_flight() -> None:
    """A closed pipe (``flight-replay | head``) costs its listener; the flight ends as planned."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def listener(event: Event) -> None:
        if vehicle.mode == "AUTO" or "RTL" in vehicle.requested:
            raise BrokenPipeError

    record = fly(vehicle, vehicle.clock, Plan(mission=route(vehicle.points)), listener)
    assert (record.ended, record.problem, vehicle.mode) == ("duration", None, "RTL")


def test_a_vehicle_that_disarms_on_the_ground_is_armed_again() -> None:
    """ArduCopter disarms itself after 10 s on the ground, and a slow link can take that long."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40, climbs=False))

    def disarm() -> None:
        flight.vehicle.armed, flight.vehicle.climbs = False, True

    flight.vehicle.schedule.append((16.0, disarm))
    assert flight.fly().problem is None
    assert flight.vehicle.requested.count("arm") == 2


def test_a_vehicle_is_armed_three_times_at_most() -> None:
    """A vehicle that disarms itself each time is an error; RTL is not needed."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40, climbs=False))
    for second in range(16, 90, 11):
        flight.vehicle.schedule.append((second, lambda: setattr(flight.vehicle, "armed", False)))
    with pytest.raises(VehicleError, match="disarmed 3 times before take-off"):
        flight.fly()
    assert flight.vehicle.requested.count("arm") == 3
    assert "RTL" not in flight.vehicle.requested


def test_a_vehicle_that_somebody_disarms_is_not_armed_again() -> None:
    """Before take-off, somebody beside it may have disarmed it."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40, climbs=False))
    flight.vehicle.schedule.append((6.0, lambda: setattr(flight.vehicle, "armed", False)))
    with pytest.raises(VehicleError, match="disarmed before take-off by the pilot"):
        flight.fly()
    assert flight.vehicle.requested.count("arm") == 1
    assert "RTL" not in flight.vehicle.requested


def test_a_vehicle_that_crashes_during_takeoff_is_not_armed_again() -> None:
    """Disarming at 15 m is not the autopilot's disarming on the ground."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))

    def crash() -> None:
        flight.vehicle.send_text("Crash: Disarming")
        flight.vehicle.armed, flight.vehicle.altitude_m = False, 0.0

    flight.vehicle.schedule.append((12.0, crash))
    with pytest.raises(VehicleError, match=r"climbing to \d+\.\d m: it says \"Crash: Disarming\""):
        flight.fly()
    assert flight.vehicle.requested.count("arm") == 1


def test_disarming_in_flight_is_a_problem() -> None:
    """The record has the status text of a crash, though the mode still is AUTO."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))

    def crash() -> None:
        flight.vehicle.send_text("Crash: Disarming")
        flight.vehicle.armed = False

    flight.vehicle.schedule.append((30.0, crash))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("disarmed", False)
    assert "Crash: Disarming" in (record.problem or "")


def test_a_disarmed_vehicle_without_a_clock_ends_the_flight() -> None:
    """Some seconds of heartbeats without a clock are enough."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def fall() -> None:
        vehicle.armed, vehicle.reports_clock = False, False

    vehicle.schedule.append((30.0, fall))
    flight = fake_flight(vehicle)
    assert flight.fly().ended == "disarmed"
    assert flight.wall_s < 45


def test_a_second_interrupt_does_not_lengthen_the_command_of_rtl() -> None:
    """A vehicle that refuses RTL is asked for 8 s from the first Ctrl-C, whatever comes then."""
    vehicle = FakeVehicle(FakeClock(), refuse_mode=frozenset({"RTL"}))

    def interrupt() -> None:
        raise KeyboardInterrupt

    vehicle.schedule += [(20.0, interrupt), (25.0, interrupt)]
    flight = fake_flight(vehicle)
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert 28.0 <= flight.wall_s < 28.5
    assert flight.of(events.ReturnCommanded) == [events.ReturnCommanded(False)]


@pytest.mark.parametrize(("speedup", "after_s"), [(1.0, 10.0), (5.0, 5.0)])
def test_a_vehicle_that_tells_no_position_is_sent_home(speedup: float, after_s: float) -> None:
    """Heartbeats and items go on for ten seconds of its time: nothing else would end the flight in time.

    A fast simulator has five of ours, in which a link that was opened again asks for positions.
    """
    flight = fake_flight(FakeVehicle(FakeClock(), points=200, speedup=speedup), duration_s=120.0)
    flight.vehicle.schedule.append((25.0, lambda: setattr(flight.vehicle, "reports_clock", False)))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("no progress", True)
    assert "has told no position for 10 s" in (record.problem or "")
    assert 25.0 + after_s - 1.0 < flight.wall_s < 25.0 + after_s + 3.0


def test_positions_that_come_again_in_time_change_nothing() -> None:
    """After 8 s of the vehicle's time."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule += [
        (30.0, lambda: setattr(flight.vehicle, "reports_clock", False)),
        (38.0, lambda: setattr(flight.vehicle, "reports_clock", True)),
    ]
    record = flight.fly()
    assert (record.ended, record.problem) == ("duration", None)


def test_a_fast_vehicle_that_reboots_is_not_taken_for_one_without_positions() -> None:
    """Twenty heartbeats a second come before its clock does."""
    vehicle = FakeVehicle(FakeClock(), points=4000, speedup=20.0)

    def reboot() -> None:
        vehicle.mode, vehicle.armed, vehicle.reports_clock = "STABILIZE", False, False
        vehicle.schedule.append((5.0, lambda: vehicle.queue.append(Rebooted())))

    vehicle.schedule.append((3.5, reboot))
    assert fake_flight(vehicle, duration_s=600.0).fly().ended == "reboot"


@pytest.mark.parametrize(("when_s", "in_auto"), [(12.0, False), (30.0, True)])
def test_an_error_of_the_program_on_the_link_commands_rtl(when_s: float, in_auto: bool) -> None:
    """At once, and it is told as what it is."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))

    def fail() -> None:
        raise LinkFaultError("nothing is heard: internal error")

    flight.vehicle.schedule.append((when_s, fail))
    if in_auto:
        record = flight.fly()
        assert (record.ended, record.problem) == ("internal error", "nothing is heard: internal error")
        assert record.waypoints_reached > 0
    else:
        with pytest.raises(VehicleError, match="nothing is heard: internal error"):
            flight.fly()
    assert flight.of(events.ReturnCommanded) == [events.ReturnCommanded(True)]
    assert flight.wall_s < when_s + 3.0

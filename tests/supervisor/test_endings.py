"""The supervisor when things end early: interrupts, lost links, reboots, motors that stop, other missions."""

from __future__ import annotations

import pytest

from flight_replay import events
from flight_replay.errors import PhaseTimeoutError, VehicleError
from flight_replay.events import Event
from flight_replay.supervisor import Deadlines, Plan, fly
from flight_replay.supervisor.vehicle_interface import MissionCurrent, Rebooted
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle, route
from tests.helpers.supervised import fake_flight


@pytest.mark.parametrize("when_s", [6.0, 12.0, 20.0, 30.0])
def test_ctrl_c_sends_the_vehicle_home(when_s: float) -> None:
    """An interrupt in the air commands RTL first, says that it is confirmed, and goes on up."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))

    def interrupt() -> None:
        raise KeyboardInterrupt

    flight.vehicle.schedule.append((when_s, interrupt))
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert flight.vehicle.mode == "RTL"
    assert flight.of(events.ReturnCommanded) == [events.ReturnCommanded(True)]
    assert flight.wall_s < when_s + 10


def test_an_interrupt_before_arming_commands_nothing() -> None:
    """Nothing was armed, so nothing is sent home."""
    flight = fake_flight()

    def interrupt() -> None:
        raise KeyboardInterrupt

    flight.vehicle.schedule.append((1.0, interrupt))
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert "RTL" not in flight.vehicle.requested


def test_a_link_that_comes_back_is_used_again() -> None:
    """12 s of silence are told within 5 s, and the flight ends as asked."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule += [
        (30.0, lambda: setattr(flight.vehicle, "silent", True)),
        (42.0, lambda: setattr(flight.vehicle, "silent", False)),
    ]
    record = flight.fly()
    assert (record.ended, record.problem) == ("duration", None)
    (lost,), (back,) = flight.of(events.LinkLost), flight.of(events.LinkRestored)
    assert lost.silent_s < 5 < back.silent_s


def test_a_link_lost_for_ever_ends_with_what_is_known() -> None:
    """After the time allowed, RTL is tried into the void and the record says what happened."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((30.0, lambda: setattr(flight.vehicle, "silent", True)))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("link lost", False)
    assert record.waypoints_reached > 0
    assert flight.vehicle.requested[-1] == "RTL"
    assert flight.wall_s < 30 + 30 + 10


def test_a_reboot_in_the_air_ends_the_flight() -> None:
    """Whatever was known before is void; RTL is asked of what is left."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((30.0, lambda: flight.vehicle.queue.append(Rebooted())))
    record = flight.fly()
    assert record.ended == "reboot"
    assert "RTL" in flight.vehicle.requested


def test_a_reboot_on_the_ground_is_an_error() -> None:
    """Before arming nothing is commanded any more."""
    flight = fake_flight()
    flight.vehicle.schedule.append((2.0, lambda: flight.vehicle.queue.append(Rebooted())))
    with pytest.raises(VehicleError, match="rebooted"):
        flight.fly()
    assert "RTL" not in flight.vehicle.requested


def test_a_mission_that_changes_in_flight_is_left() -> None:
    """Another count of items on board than at the start ends AUTO with RTL."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((30.0, lambda: flight.vehicle.queue.append(MissionCurrent(3, 7))))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("mission changed", True)


def test_a_mission_of_the_same_length_uploaded_in_flight_is_left() -> None:
    """The count does not show it, but the vehicle's words do: nothing unverified is flown on."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))
    flight.vehicle.schedule.append((2.0, lambda: flight.vehicle.send_text("Flight plan received", 6)))
    flight.vehicle.schedule.append((30.0, lambda: flight.vehicle.send_text("Flight plan received", 6)))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("mission changed", True)
    assert record.auto_s < 30


def test_rtl_that_is_refused_is_a_problem() -> None:
    """A vehicle that does not confirm RTL leaves the record with a problem."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40, refuse_mode=frozenset({"RTL"})))
    record = flight.fly()
    assert not record.rtl_confirmed
    assert "did not confirm RTL" in (record.problem or "")


def test_a_clock_that_stands_still_does_not_hold_the_wait() -> None:
    """A vehicle whose time never moves is given up by the clock here."""
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
    """ArduCopter disarms itself after 10 s on the ground, which a slow link can take."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40, climbs=False))

    def disarm() -> None:
        flight.vehicle.armed, flight.vehicle.climbs = False, True

    flight.vehicle.schedule.append((16.0, disarm))
    assert flight.fly().problem is None
    assert flight.vehicle.requested.count("arm") == 2


def test_a_vehicle_that_keeps_disarming_is_given_up() -> None:
    """Three times is enough; nothing is left to be sent home."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40, climbs=False))
    for second in range(16, 90, 11):
        flight.vehicle.schedule.append((second, lambda: setattr(flight.vehicle, "armed", False)))
    with pytest.raises(VehicleError, match="disarmed 3 times before take-off"):
        flight.fly()
    assert flight.vehicle.requested.count("arm") == 3
    assert "RTL" not in flight.vehicle.requested


def test_a_vehicle_that_somebody_disarms_is_not_armed_again() -> None:
    """Before it lifts off, somebody may have walked up to it and stopped its motors."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40, climbs=False))
    flight.vehicle.schedule.append((6.0, lambda: setattr(flight.vehicle, "armed", False)))
    with pytest.raises(VehicleError, match="disarmed before take-off by the pilot"):
        flight.fly()
    assert flight.vehicle.requested.count("arm") == 1
    assert "RTL" not in flight.vehicle.requested


def test_a_vehicle_that_falls_while_it_climbs_is_not_armed_again() -> None:
    """A crash at 15 m is no vehicle that waited too long on the ground."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))

    def crash() -> None:
        flight.vehicle.send_text("Crash: Disarming")
        flight.vehicle.armed, flight.vehicle.altitude_m = False, 0.0

    flight.vehicle.schedule.append((12.0, crash))
    with pytest.raises(VehicleError, match=r"climbing to \d+\.\d m: it says \"Crash: Disarming\""):
        flight.fly()
    assert flight.vehicle.requested.count("arm") == 1


def test_a_vehicle_that_disarms_in_flight_is_no_success() -> None:
    """A crash ends the flight with the vehicle's words, though its mode still is AUTO."""
    flight = fake_flight(FakeVehicle(FakeClock(), points=40))

    def crash() -> None:
        flight.vehicle.send_text("Crash: Disarming")
        flight.vehicle.armed = False

    flight.vehicle.schedule.append((30.0, crash))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("disarmed", False)
    assert "Crash: Disarming" in (record.problem or "")


def test_a_disarmed_vehicle_that_never_tells_its_clock_is_not_waited_for() -> None:
    """Some seconds of heartbeats without a clock are enough."""
    vehicle = FakeVehicle(FakeClock(), points=40)

    def fall() -> None:
        vehicle.armed, vehicle.reports_clock = False, False

    vehicle.schedule.append((30.0, fall))
    flight = fake_flight(vehicle)
    assert flight.fly().ended == "disarmed"
    assert flight.wall_s < 45

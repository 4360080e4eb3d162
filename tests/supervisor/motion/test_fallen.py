"""A vehicle that has fallen is sent home; one that lies there and does not move is to disarm."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from flight_replay.events import Notice, ReturnCommanded
from flight_replay.exceptions import VehicleError
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle
from tests.helpers.supervised import FakeFlight, fake_flight

_STAYS = "the vehicle stays where it fell"
_DISARMED = f"{_STAYS}, and has disarmed in LAND"


def _fall(vehicle: FakeVehicle, to_m: float = 0.2) -> None:
    vehicle.altitude_m, vehicle.climbs = to_m, False


def _flight_with_a_fall(
    at_s: float = 30.0,
    *,
    rtl_m_s: float = 0.0,
    disarms: bool = True,
    to_m: float = 0.2,
    then: Callable[[FakeVehicle], None] | None = None,
    **plan: object,
) -> FakeFlight:
    """It falls to ``to_m`` after ``at_s``, RTL lifts it by ``rtl_m_s``, and LAND disarms it after 5 s.

    ``then`` happens 3 s after RTL was requested.
    """
    vehicle = FakeVehicle(FakeClock(), points=40)
    vehicle.schedule.append((at_s, lambda: _fall(vehicle, to_m)))
    request_mode, move, land = vehicle.request_mode, vehicle.move, vehicle.land

    def request(mode: str) -> None:
        if mode == "RTL" and then is not None and "RTL" not in vehicle.requested:
            vehicle.schedule.insert(0, (vehicle.clock.now_s - vehicle.began_s + 3.0, lambda: then(vehicle)))
        request_mode(mode)

    def stay(step_s: float) -> None:
        if vehicle.mode == "LAND" and disarms:
            land(step_s)
        elif vehicle.mode == "RTL":
            vehicle.altitude_m += rtl_m_s * step_s

    vehicle.request_mode, vehicle.move, vehicle.land = request, move, stay  # type: ignore[method-assign]
    return fake_flight(vehicle, **plan)


def _warnings(flight: FakeFlight) -> list[str]:
    return [notice.text for notice in flight.of(Notice) if notice.warning]


@pytest.mark.parametrize("land", [False, True], ids=["leaving at RTL", "waiting for the landing"])
def test_a_vehicle_that_lies_where_it_fell_disarms(land: bool) -> None:
    """RTL first, as always; LAND when it has not moved for some seconds, and nobody can have come near."""
    flight = _flight_with_a_fall(land=land)
    record = flight.fly()
    assert flight.vehicle.requested[-2:] == ["RTL", "LAND"]
    assert not flight.vehicle.armed
    assert (record.ended, record.rtl_confirmed, record.landed) == ("off course", True, False)
    assert record.problem is not None
    assert record.problem.startswith(f"{_DISARMED}; before that the vehicle sinks, or has fallen")
    assert f"{_STAYS}; LAND is commanded, so that it disarms" in _warnings(flight)


def test_a_vehicle_that_rtl_lifts_flies_home() -> None:
    """The barometer was wrong for a moment, or the motors are back."""
    flight = _flight_with_a_fall(rtl_m_s=1.0)
    record = flight.fly()
    assert flight.vehicle.requested[-1] == "RTL"
    assert record.problem is not None
    assert _STAYS not in record.problem


def test_a_vehicle_that_somebody_takes_is_not_told_to_land() -> None:
    flight = _flight_with_a_fall(then=lambda vehicle: setattr(vehicle, "mode", "STABILIZE"))
    record = flight.fly()
    assert flight.vehicle.requested[-1] == "RTL"
    assert record.problem is not None
    assert record.problem.startswith("the mode was changed to STABILIZE")


def test_a_vehicle_that_does_not_disarm_is_told() -> None:
    record = _flight_with_a_fall(disarms=False).fly()
    assert record.problem is not None
    assert record.problem.startswith(f"{_STAYS}, and has not disarmed in LAND: keep away, and disarm it ")


def test_a_vehicle_that_hovers_weakly_has_the_time_to_land() -> None:
    """Whoever disarmed it before it is down would let it fall."""
    flight = _flight_with_a_fall(to_m=12.0)
    vehicle, move = flight.vehicle, flight.vehicle.land

    def sink(step_s: float) -> None:
        if vehicle.mode == "LAND" and vehicle.altitude_m > 0.5:
            vehicle.altitude_m -= 0.5 * step_s
        else:
            move(step_s)

    vehicle.land = sink  # type: ignore[method-assign]
    record = flight.fly()
    assert record.problem is not None
    assert record.problem.startswith(_DISARMED)


def test_a_vehicle_that_disarms_by_itself_is_left_alone() -> None:
    """ArduCopter's crash check disarms it where it lies on its side."""
    flight = _flight_with_a_fall(then=lambda vehicle: setattr(vehicle, "armed", False))
    flight.fly()
    assert flight.vehicle.requested[-1] == "RTL"


def test_a_vehicle_that_falls_in_take_off_disarms() -> None:
    flight = _flight_with_a_fall(at_s=12.0)
    with pytest.raises(VehicleError, match="sank from"):
        flight.fly()
    assert flight.vehicle.requested[-2:] == ["RTL", "LAND"]
    assert flight.of(ReturnCommanded) == [ReturnCommanded(True)]
    assert _warnings(flight)[-1] == _DISARMED


def test_a_vehicle_that_falls_on_its_way_home_disarms() -> None:
    """Whoever looks for it a minute later finds its motors at rest."""
    flight = _flight_with_a_fall(at_s=1e9, then=_fall, land=True, duration_s=10.0)
    record = flight.fly()
    assert flight.vehicle.requested[-2:] == ["RTL", "LAND"]
    assert (record.ended, record.problem, record.landed) == ("duration", _DISARMED, False)


def test_a_vehicle_that_a_failsafe_sent_home_is_not_told_to_land() -> None:
    """Of one that somebody else has, nothing more is commanded, though it falls on the way."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    vehicle.land = lambda step_s: None  # type: ignore[method-assign]

    def failsafe() -> None:
        vehicle.send_text("Battery Failsafe")
        vehicle.mode = "RTL"

    vehicle.schedule += [(30.0, failsafe), (36.0, lambda: _fall(vehicle))]
    record = fake_flight(vehicle, land=True).fly()
    assert record.ended == "failsafe"
    assert record.problem is not None
    assert record.problem.startswith("the vehicle did not land and disarm")
    assert not {"RTL", "LAND"} & set(vehicle.requested)


def test_a_vehicle_that_waits_over_home_has_not_fallen() -> None:
    """RTL hovers there for RTL_LOIT_TIME, which may be long, before it lands."""
    flight = _flight_with_a_fall(at_s=16.0, to_m=8.0)
    with pytest.raises(VehicleError, match="sank from"):
        flight.fly()
    assert flight.vehicle.requested[-1] == "RTL"


def test_an_interrupt_does_not_start_the_motors_again() -> None:
    """RTL would, of a vehicle that LAND is about to disarm."""
    flight = _flight_with_a_fall(disarms=False)
    vehicle, request_mode = flight.vehicle, flight.vehicle.request_mode

    def interrupt() -> None:
        raise KeyboardInterrupt

    def request(mode: str) -> None:
        request_mode(mode)
        if mode == "LAND":
            vehicle.schedule.append((vehicle.clock.now_s - vehicle.began_s + 2.0, interrupt))

    vehicle.request_mode = request  # type: ignore[method-assign]
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert vehicle.requested[-1] == "LAND"
    assert "no RTL is commanded: LAND was, so that it disarms" in _warnings(flight)


def test_a_vehicle_known_to_be_disarmed_is_told_as_that() -> None:
    """Not as one to keep away from until it is: a fast simulator falls before its clock excludes a reboot."""
    vehicle = FakeVehicle(FakeClock(), points=40, speedup=10.0)

    def fall() -> None:
        vehicle.altitude_m, vehicle.armed = 0.2, False

    vehicle.schedule.append((3.5, fall))
    flight = fake_flight(vehicle)
    record = flight.fly()
    assert record.ended == "disarmed"
    assert not any("sinks" in warning for warning in _warnings(flight))

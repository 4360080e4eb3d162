"""The default deadlines, by what flights do."""

from __future__ import annotations

import pytest

from flight_replay import events
from flight_replay.exceptions import PhaseTimeoutError
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle
from tests.helpers.supervised import fake_flight


def interrupt() -> None:
    raise KeyboardInterrupt


def test_rtl_after_an_interrupt_is_requested_for_eight_seconds() -> None:
    """Then the program ends: it has ten seconds for everything."""
    vehicle = FakeVehicle(FakeClock(), points=40, refuse_mode=frozenset({"RTL"}))
    vehicle.schedule.append((40.0, interrupt))
    flight = fake_flight(vehicle)
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert 47.9 < flight.wall_s < 49.0


def test_a_pilot_who_takes_over_after_an_interrupt_is_not_overruled() -> None:
    """RTL is not requested again, although it was never confirmed."""
    vehicle = FakeVehicle(FakeClock(), points=40, refuse_mode=frozenset({"RTL"}))
    vehicle.schedule += [(40.0, interrupt), (42.0, lambda: setattr(vehicle, "mode", "LOITER"))]
    flight = fake_flight(vehicle)
    with pytest.raises(KeyboardInterrupt):
        flight.fly()
    assert flight.wall_s < 44.0


def test_the_vehicle_has_three_minutes_to_get_ready() -> None:
    """GPS and estimator take up to two."""
    flight = fake_flight(FakeVehicle(FakeClock(), ready_after_s=1e6))
    with pytest.raises(PhaseTimeoutError, match="was not ready to arm in 180 s"):
        flight.fly()
    assert 179.9 < flight.wall_s < 181.0


def test_no_phase_ends_within_five_seconds_however_fast_the_vehicles_clock_runs() -> None:
    """15 s of a clock that runs 20 times as fast would be over before a lost packet is sent again."""
    flight = fake_flight(FakeVehicle(FakeClock(), speedup=20.0, refuse_mode=frozenset({"GUIDED"})))
    with pytest.raises(PhaseTimeoutError, match="did not change to GUIDED in 15 s"):
        flight.fly()
    assert 5.0 < flight.wall_s < 6.0


def test_a_link_counts_as_lost_after_four_seconds_of_silence() -> None:
    """Shorter silences are not told."""
    vehicle = FakeVehicle(FakeClock(), points=40)
    vehicle.schedule += [
        (30.0, lambda: setattr(vehicle, "silent", True)),
        (33.9, lambda: setattr(vehicle, "silent", False)),
        (40.0, lambda: setattr(vehicle, "silent", True)),
        (45.0, lambda: setattr(vehicle, "silent", False)),
    ]
    flight = fake_flight(vehicle)
    flight.fly()
    (lost,) = flight.of(events.LinkLost)
    assert 3.99 < lost.silent_s < 4.3

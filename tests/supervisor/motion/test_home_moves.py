"""Home that somebody moves in flight is told, because RTL goes there; home that arming sets is not."""

from __future__ import annotations

import pytest

from flight_replay.events import Notice, VehicleState
from flight_replay.supervisor.motion.home_moves import HomeMoves
from flight_replay.supervisor.vehicle_interface import HomePosition
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle
from tests.helpers.supervised import fake_flight

ARMED_AT = VehicleState(10.0, 47.0, 8.0, 0.0, (0, 0, 0), None, "GUIDED", True)


def home(north_m: float = 0.0, amsl_m: float = 500.0) -> HomePosition:
    return HomePosition(47.0 + 9e-6 * north_m, 8.0, amsl_m)


def test_home_that_is_set_before_the_flight_is_not_told() -> None:
    """Arming moves it to where the vehicle is, wherever it was; the vehicle may tell that late."""
    moves = HomeMoves()
    assert moves.told(home(80.0), None, 0.0) == ""
    assert moves.told(home(0.5, 503.0), ARMED_AT, 0.2) == ""
    assert moves.told(home(0.5, 503.0), ARMED_AT, 30.0) == ""
    assert moves.moved_m == 0.0


@pytest.mark.parametrize("known", [True, False])
def test_home_that_is_moved_in_flight_is_told_once(known: bool) -> None:
    """Also where the vehicle did not tell where it was before."""
    moves = HomeMoves()
    if known:
        moves.told(home(), None, 0.0)
    assert moves.told(home(100.0), ARMED_AT, 30.0).startswith(
        "home was moved to 100 m from where the vehicle was armed: RTL goes there; keep "
    )
    assert moves.told(home(100.0), ARMED_AT, 30.0) == ""
    assert moves.moved_m == pytest.approx(100.0, abs=0.2)


@pytest.mark.parametrize(("rise_m", "words"), [(30.0, "30 m higher"), (-20.0, "20 m lower")])
def test_home_at_another_height_is_told(rise_m: float, words: str) -> None:
    """Heights of a mission are above it."""
    moves = HomeMoves()
    moves.told(home(), None, 0.0)
    told = moves.told(home(1.0, 500.0 + rise_m), ARMED_AT, 30.0)
    assert f"armed, {words} than it was: RTL goes there, and the heights of a mission are above it; " in told


def test_a_flight_whose_home_is_moved_goes_on() -> None:
    """With a warning; it may land farther away than a vehicle that is driven away would be."""
    vehicle = FakeVehicle(FakeClock(), points=40, rtl_north_m=700.0)
    vehicle.schedule.append((30.0, lambda: vehicle.queue.append(home(900.0))))
    flight = fake_flight(vehicle, land=True)
    record = flight.fly()
    assert (record.ended, record.problem, record.landed) == ("duration", None, True)
    told = [event.text for event in flight.of(Notice) if event.warning]
    assert len(told) == 1
    assert told[0].startswith("home was moved to 900 m from")

"""Vehicle time between positions."""

from __future__ import annotations

import pytest

from flight_replay.supervisor.vehicle_clock import VehicleClock


@pytest.mark.parametrize("rate", [1.0, 10.0])
def test_goes_on_between_positions_at_the_vehicles_rate(rate: float) -> None:
    clock = VehicleClock()
    for i in range(100):
        clock.received(50.0 + 0.1 * i, 7.0 + 0.1 * i / rate)
    assert clock.rate == pytest.approx(rate, rel=0.01)
    assert clock.now_s(7.0 + 9.95 / rate) == pytest.approx(59.95, abs=0.01)


def test_late_positions_do_not_set_it_back() -> None:
    clock = VehicleClock()
    for i in range(50):
        delay_s = 0.1 if i % 5 else 0.0
        clock.received(50.0 + 0.1 * i, 7.0 + 0.1 * i + delay_s)
    now_s = clock.now_s(7.0 + 4.9 + 0.1)
    assert now_s is not None
    assert now_s == pytest.approx(55.0, abs=0.02)


def test_knows_nothing_before_the_first_position_or_long_after_the_last() -> None:
    clock = VehicleClock()
    assert clock.now_s(1.0) is None
    clock.received(50.0, 1.0)
    assert clock.now_s(1.5) == pytest.approx(50.5)
    assert clock.now_s(3.0) is None


def test_positions_out_of_order_are_ignored() -> None:
    clock = VehicleClock()
    clock.received(50.0, 1.0)
    clock.received(49.0, 1.1)
    assert clock.now_s(1.1) == pytest.approx(50.1)


@pytest.mark.parametrize("stall_s", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("rate", [1.0, 10.0])
def test_positions_that_were_held_up_do_not_make_it_run_fast(rate: float, stall_s: float) -> None:
    """After a stall of this program, or of the link, those of the whole stall come at once."""
    clock, sent = VehicleClock(), iter(range(1, 100_000))
    time_s = 0.1 * next(sent)
    for step in range(1000):
        wall_s = 0.01 * step
        if 5.0 < wall_s < 5.0 + stall_s:
            continue
        while time_s <= wall_s * rate:
            clock.received(time_s, wall_s)
            time_s = 0.1 * next(sent)
        if wall_s > 1.0:
            now_s = clock.now_s(wall_s)
            assert now_s == pytest.approx(wall_s * rate, abs=0.12)
            assert clock.rate == pytest.approx(rate, rel=0.1)


def test_the_freshest_position_of_the_last_second_tells_the_time() -> None:
    """All positions come 0.1 s late but one, which counts until the newest is a second later."""
    clock = VehicleClock()
    told_s = []
    for i in range(32):
        wall_s = 7.0 + 0.1 * i + (0.0 if i == 20 else 0.1)
        clock.received(50.0 + 0.1 * i, wall_s)
        told_s.append(clock.now_s(7.1 + 0.1 * i))
    assert told_s[29] == pytest.approx(53.0)
    assert told_s[31] == pytest.approx(53.1)


@pytest.mark.parametrize(("late_s", "held_up"), [(0.25, False), (0.35, True)])
def test_a_position_more_than_0_3_s_late_was_held_up(late_s: float, held_up: bool) -> None:
    """Then it alone tells the time; otherwise those before it, which came in time, still do."""
    clock = VehicleClock()
    for i in range(20):
        clock.received(50.0 + 0.1 * i, 7.0 + 0.1 * i)
    clock.received(52.0, 9.0 + late_s)
    now_s = clock.now_s(9.0 + late_s)
    assert now_s is not None
    assert now_s == pytest.approx(52.0 if held_up else 52.0 + late_s, abs=0.06)


@pytest.mark.parametrize(("after_s", "counts"), [(0.28, False), (0.32, True)])
def test_positions_within_0_3_s_of_one_that_was_held_up_were_so_too(after_s: float, counts: bool) -> None:
    """Each of them alone tells the time; later ones are compared again."""
    clock = VehicleClock()
    for i in range(20):
        clock.received(50.0 + 0.1 * i, 7.0 + 0.1 * i)
    clock.received(52.0, 10.0)
    clock.received(52.1, 10.0 + after_s)
    rate = clock.rate
    now_s = clock.now_s(10.0 + after_s)
    assert now_s == pytest.approx(52.0 + after_s * rate if counts else 52.1)


def test_the_rate_is_that_of_the_last_two_seconds() -> None:
    """From a quarter of a second on; a slow first step counts until it is more than 2 s ago."""
    clock = VehicleClock(4.0)
    clock.received(50.0, 7.0)
    clock.received(50.0625, 7.125)
    assert clock.rate == 4.0
    rates = []
    for i in range(1, 10):
        clock.received(49.875 + 0.25 * i, 7.0 + 0.25 * i)
        rates.append(clock.rate)
    assert (rates[0], rates[7], rates[8]) == (0.5, 1.875 / 2.0, 1.0)

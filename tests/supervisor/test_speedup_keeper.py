"""Simulators that are slowed down where this process is late, on a virtual clock."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.events import Following, Notice
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle
from tests.helpers.supervised import FakeFlight, fake_following


def _busy_flight(speedup: float, stall_wall_s: float, *, times: int = 10_000, own: bool = True) -> FakeFlight:
    """A flight of a process that does not run for a while again and again, from when it follows on."""
    vehicle = FakeVehicle(FakeClock(), speedup=speedup)
    flight = fake_following(vehicle, duration_s=None, speedup=speedup if own else None)
    left = [times]

    def stall() -> None:
        if flight.of(Following) and left[0]:
            left[0] -= 1
            vehicle.clock.now_s += stall_wall_s
        vehicle.schedule.append((vehicle.clock.now_s - vehicle.began_s + 0.1, stall))

    vehicle.schedule.append((0.1, stall))
    return flight


def _speedups(flight: FakeFlight) -> list[str]:
    return [each for each in flight.vehicle.requested if each.startswith("speedup")]


def test_a_machine_that_is_too_busy_lowers_the_speedup_until_targets_come_in_time() -> None:
    flight = _busy_flight(20.0, 0.04)
    record = flight.fly()
    assert record.ended == "recording complete"
    speedups = [float(each.split()[1]) for each in _speedups(flight)]
    assert len(speedups) >= 2
    assert speedups == sorted(speedups, reverse=True)
    assert 1.0 < speedups[-1] <= 7.5  # 40 ms are then at most 0.3 s.
    notices = flight.of(Notice)
    assert len(notices) == len(speedups)
    assert "this machine is too busy for a speedup of 20; the simulator goes on at" in notices[0].text
    gaps_s = np.diff([time_s for time_s, _ in flight.vehicle.targets])
    assert gaps_s[len(gaps_s) // 2 :].max() <= 0.4


def test_one_stall_is_no_reason() -> None:
    flight = _busy_flight(10.0, 0.2, times=1)
    assert flight.fly().ended == "recording complete"
    assert _speedups(flight) == []


@pytest.mark.parametrize("speedup", [1.0, 1.5])
def test_no_simulator_runs_slower_than_real_time(speedup: float) -> None:
    flight = _busy_flight(speedup, 0.35)
    flight.fly()
    assert _speedups(flight) == (["speedup 1"] if speedup > 1.0 else [])


def test_simulators_of_others_keep_their_speed() -> None:
    flight = _busy_flight(20.0, 0.04, own=False)
    flight.fly()
    assert _speedups(flight) == []


def test_an_idle_machine_keeps_the_speed() -> None:
    flight = _busy_flight(20.0, 0.0)
    flight.fly()
    assert _speedups(flight) == []

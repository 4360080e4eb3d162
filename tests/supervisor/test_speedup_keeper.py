"""Simulators that are slowed down where this process is late, on a virtual clock."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.events import Event, Following, Notice
from flight_replay.supervisor import Deadlines
from flight_replay.supervisor.speedup_keeper import SpeedupKeeper
from flight_replay.supervisor.vehicle_clock import VehicleClock
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor
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


class Kept:
    """A keeper that a test tells of targets."""

    def __init__(self, speedup: float | None = 20.0, rate: float = 20.0) -> None:
        self.vehicle, self.events = FakeVehicle(FakeClock()), list[Event]()
        self.clock = VehicleClock(rate)
        monitor = VehicleMonitor(self.vehicle, self.vehicle.clock, self.events.append, Deadlines())
        self.keeper = SpeedupKeeper(monitor, self.clock, speedup)

    def sent(self, *targets: tuple[float, float]) -> list[str]:
        """What was requested after targets at these times, each with the gap before it."""
        for time_s, gap_s in targets:
            self.keeper.target_sent(time_s, gap_s)
        return self.vehicle.requested


@pytest.mark.parametrize(
    ("targets", "slower"),
    [
        ([(50.0, 0.31), (55.0, 0.31)], True),
        ([(50.0, 0.3), (51.0, 0.31)], False),
        ([(50.0, 0.31), (51.0, 0.3)], False),
        ([(50.0, 0.4), (55.1, 0.4)], False),
        ([(50.0, 0.4), (55.1, 0.4), (60.0, 0.4)], True),
    ],
    ids=["twice in 5 s", "first in time", "second in time", "too far apart", "third after the second"],
)
def test_two_targets_later_than_0_3_s_within_5_s_halve_the_speed(
    targets: list[tuple[float, float]], slower: bool
) -> None:
    assert Kept().sent(*targets) == (["speedup 10"] if slower else [])


def test_each_halving_needs_two_late_targets_of_its_own() -> None:
    kept = Kept()
    assert kept.sent((50.0, 0.4), (51.0, 0.4), (52.0, 0.4)) == ["speedup 10"]
    assert kept.sent((53.0, 0.4)) == ["speedup 10", "speedup 5"]


@pytest.mark.parametrize(
    ("speedup", "rate", "slower"), [(20.0, 13.0, 6.5), (20.0, 4.12, 2.1), (5.0, 20.0, 2.5), (1.5, 1.5, 1.0)]
)
def test_half_of_the_speed_that_was_reached_is_requested(speedup: float, rate: float, slower: float) -> None:
    """To a tenth, and not below real time; the clock goes on at that rate."""
    kept = Kept(speedup, rate)
    assert kept.sent((50.0, 0.4), (51.0, 0.5)) == [f"speedup {slower:g}"]
    assert kept.clock.rate == slower
    (notice,) = kept.events
    assert isinstance(notice, Notice)
    assert notice.text.startswith(" Targets came 0.5 s apart")
    assert f"speedup of {speedup:g}; the simulator goes on at {slower:g}" in notice.text


@pytest.mark.parametrize("speedup", [None, 1.0, 0.5])
def test_nothing_is_requested_at_real_time_or_of_others(speedup: float | None) -> None:
    assert Kept(speedup).sent((50.0, 0.4), (51.0, 0.4), (52.0, 0.4)) == []

"""Deadlines, retries and progress by two clocks: the vehicle's and wall-clock time."""

from __future__ import annotations

from flight_replay.events import VehicleState
from flight_replay.supervisor import Deadlines
from flight_replay.supervisor.timers import Deadline, ProgressTimer, RetryTimer
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle


class Clocks:
    """A monitor whose two clocks a test advances: ``pass_time(wall_s, vehicle_s)``."""

    def __init__(self) -> None:
        self.clock = FakeClock(0.0)
        self.vehicle = FakeVehicle(self.clock)
        self.vehicle.reports = lambda timeout_s: [self._state()]  # type: ignore[method-assign]
        self.time_s = 50.0
        self.monitor = VehicleMonitor(
            self.vehicle, self.clock, lambda event: None, Deadlines(min_wall_s=5.0, give_up_wall_s=1e9)
        )
        self.monitor.step()

    def _state(self) -> VehicleState:
        return VehicleState(self.time_s, 47.0, 8.0, 0.0, (0, 0, 0), None, "AUTO", True)

    def pass_time(self, wall_s: float, vehicle_s: float) -> None:
        """Advance both clocks in steps shorter than a gap of the link."""
        steps = max(int(wall_s / 0.5), 1)
        for _ in range(steps):
            self.clock.now_s += wall_s / steps
            self.time_s += vehicle_s / steps
            self.monitor.step()


def test_a_deadline_counts_vehicle_time() -> None:
    """The limit is exact when both clocks run equally fast."""
    clocks = Clocks()
    deadline = Deadline(clocks.monitor, 10.0)
    clocks.pass_time(10.0, 10.0)
    assert not deadline.passed
    clocks.pass_time(0.1, 0.1)
    assert deadline.passed


def test_a_restarted_deadline_waits_the_whole_limit_again() -> None:
    """Both clocks start from the restart."""
    clocks = Clocks()
    deadline = Deadline(clocks.monitor, 10.0)
    clocks.pass_time(9.0, 9.0)
    deadline.restart()
    clocks.pass_time(9.0, 9.0)
    assert not deadline.passed
    clocks.pass_time(2.0, 2.0)
    assert deadline.passed


def test_a_deadline_of_a_fast_clock_leaves_time_for_retries() -> None:
    """However fast the vehicle's clock runs, no deadline passes within 5 s, or its own limit if shorter."""
    clocks = Clocks()
    long, short = Deadline(clocks.monitor, 60.0), Deadline(clocks.monitor, 2.0)
    clocks.pass_time(2.0, 100.0)
    assert not short.passed
    clocks.pass_time(0.5, 25.0)
    assert short.passed
    assert not long.passed
    clocks.pass_time(2.5, 125.0)
    assert not long.passed
    clocks.pass_time(0.5, 25.0)
    assert long.passed


def test_a_deadline_passes_by_wall_clock_time_if_the_vehicles_clock_stands_still() -> None:
    """After three times the limit."""
    clocks = Clocks()
    deadline = Deadline(clocks.monitor, 10.0)
    clocks.pass_time(30.0, 0.0)
    assert not deadline.passed
    clocks.pass_time(0.5, 0.0)
    assert deadline.passed


def test_time_without_data_does_not_count_for_a_deadline() -> None:
    """20 s of a lost link do not use up the wait."""
    clocks = Clocks()
    deadline = Deadline(clocks.monitor, 10.0)
    clocks.clock.now_s += 20.0
    clocks.time_s += 20.0
    clocks.monitor.step()
    assert not deadline.passed
    clocks.pass_time(10.1, 10.1)
    assert deadline.passed


def test_a_request_is_due_at_once_and_again_after_its_retry_time() -> None:
    """By the vehicle's clock."""
    clocks = Clocks()
    retry = RetryTimer(clocks.monitor)
    assert retry.due(3.0)
    clocks.pass_time(2.9, 2.9)
    assert not retry.due(3.0)
    clocks.pass_time(0.1, 0.2)
    assert retry.due(3.0)
    assert not retry.due(3.0)


def test_a_fast_clock_does_not_repeat_requests_before_an_ack_can_come() -> None:
    """0.15 s of wall-clock time pass at least, or the minimum given."""
    clocks = Clocks()
    retry = RetryTimer(clocks.monitor)
    assert retry.due(3.0)
    clocks.pass_time(0.14, 10.0)
    assert not retry.due(3.0)
    clocks.pass_time(0.02, 10.0)
    assert not retry.due(3.0, 1.0)
    assert retry.due(3.0)


def test_a_clock_that_stands_still_does_not_hold_a_retry_back() -> None:
    """After 2 s, or the retry time if that is longer."""
    clocks = Clocks()
    retry = RetryTimer(clocks.monitor)
    assert retry.due(1.2)
    clocks.pass_time(1.9, 0.0)
    assert not retry.due(1.2)
    clocks.pass_time(0.2, 0.0)
    assert not retry.due(3.0)
    assert retry.due(1.2)
    clocks.pass_time(3.1, 0.0)
    assert retry.due(3.0)


def test_a_retry_is_due_as_soon_as_its_time_has_passed() -> None:
    """At the limit, not after it: by the vehicle's clock, and by wall-clock time where that stands still."""
    clocks = Clocks()
    retry = RetryTimer(clocks.monitor)
    assert retry.due(3.0)
    clocks.pass_time(0.5, 3.0)
    assert retry.due(3.0, 0.5)
    clocks.pass_time(2.0, 0.0)
    assert retry.due(1.25)
    clocks.pass_time(3.0, 0.0)
    assert retry.due(3.0)


def test_no_request_is_due_while_reports_wait() -> None:
    """One of them may be its ack, or make it wrong."""
    clocks = Clocks()
    retry = RetryTimer(clocks.monitor)
    state = clocks._state()
    clocks.vehicle.reports = lambda timeout_s: [state, state]  # type: ignore[method-assign]
    clocks.monitor.step()
    assert not retry.due(1.0)
    clocks.monitor.step()
    assert retry.due(1.0)


def test_progress_is_due_every_second_of_the_faster_clock() -> None:
    """At once, then after a second of either clock."""
    clocks = Clocks()
    progress = ProgressTimer(clocks.monitor)
    assert progress.due()
    clocks.pass_time(0.9, 0.9)
    assert not progress.due()
    clocks.pass_time(0.1, 0.2)
    assert progress.due()
    clocks.pass_time(0.3, 1.1)
    assert progress.due()
    clocks.pass_time(1.1, 0.0)
    assert progress.due()
    assert not progress.due()

"""When waits time out, when requests are sent again and when progress is emitted, by two clocks.

Vehicle time is what the durations of a flight mean. Wall-clock time bounds them, because the clock
of a simulator may run 20 times faster, and that of a frozen vehicle stands still.
"""

from __future__ import annotations

from flight_replay.supervisor.vehicle_monitor import VehicleMonitor

RETRY_S = 1.2
"""Heartbeats show once a second what came of a request that was answered."""
_MIN_RETRY_WALL_S = 0.15  # No request is sent again sooner: the ack may be on its way.
_CLOCK_STOPPED_WALL_S = 2.0  # While the vehicle's clock stands still, requests are sent again after this.
_MAX_WALL_FACTOR = 3.0
_PROGRESS_S = 1.0
_NEVER_S = float("-inf")


class Deadline:
    """The end of a wait: ``limit_s`` of vehicle time, bounded by wall-clock time.

    Time without data from the vehicle does not count. A clock that runs fast leaves at least
    ``min_wall_s``, so that lost packets can be sent again; one that stands still, at most three
    times the limit.
    """

    def __init__(self, monitor: VehicleMonitor, limit_s: float) -> None:
        self._monitor = monitor
        self._limit_s = limit_s
        self.restart()

    def restart(self) -> None:
        """Wait the whole limit again from now."""
        self._link_up_s, self._wall_s = self._monitor.link_up_s, self._monitor.wall_s

    @property
    def passed(self) -> bool:
        """Whether the wait is over."""
        wall_s = self._monitor.wall_s - self._wall_s
        vehicle_s = self._monitor.link_up_s - self._link_up_s
        min_wall_s = min(self._monitor.deadlines.min_wall_s, self._limit_s)
        too_long = wall_s > _MAX_WALL_FACTOR * self._limit_s
        return too_long or (vehicle_s > self._limit_s and wall_s > min_wall_s)


class RetryTimer:
    """When a request is to be sent: at once, then again while nothing comes of it.

    Never while reports wait to be processed: one of them may be the ack, or make the request wrong.
    """

    def __init__(self, monitor: VehicleMonitor) -> None:
        self._monitor = monitor
        self._time_s = self._wall_s = _NEVER_S

    def due(self, retry_s: float, min_wall_s: float = _MIN_RETRY_WALL_S) -> bool:
        """Whether ``retry_s`` of vehicle time and ``min_wall_s`` passed since this was last true."""
        wall_s = self._monitor.wall_s - self._wall_s
        vehicle_s = self._monitor.time_s - self._time_s
        early = wall_s < min_wall_s or (vehicle_s < retry_s and wall_s < max(retry_s, _CLOCK_STOPPED_WALL_S))
        if early or not self._monitor.caught_up:
            return False
        self._time_s, self._wall_s = self._monitor.time_s, self._monitor.wall_s
        return True


class ProgressTimer:
    """When progress is to be emitted: every second, by whichever clock runs faster."""

    def __init__(self, monitor: VehicleMonitor) -> None:
        self._monitor = monitor
        self._time_s = self._wall_s = _NEVER_S

    def due(self) -> bool:
        """Whether a second of either clock passed since this was last true."""
        vehicle_s = self._monitor.time_s - self._time_s
        if vehicle_s < _PROGRESS_S and self._monitor.wall_s - self._wall_s < _PROGRESS_S:
            return False
        self._time_s, self._wall_s = self._monitor.time_s, self._monitor.wall_s
        return True

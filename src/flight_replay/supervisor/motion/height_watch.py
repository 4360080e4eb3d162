"""A vehicle that comes far below all that it is to fly has fallen, or is about to."""

from __future__ import annotations

from flight_replay.supervisor import flight_ended
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor

_SUNK_M, _SUNK_S = 3.0, 2.5
"""So far below the lowest height, and half of that, for so long; heartbeats tell within that of one that
disarmed, and heights of an estimator that changes its mind come back."""


class HeightWatch:
    """The vehicle's height, beside the lowest that it is to be at."""

    def __init__(self, monitor: VehicleMonitor, lowest_m: float) -> None:
        """Watch it where ``lowest_m`` above home, at which the vehicle is by now, allows."""
        self._monitor, self._lowest_m = monitor, lowest_m
        self._too_low_m = min(lowest_m / 2, lowest_m - _SUNK_M)
        self._since_s: float | None = None

    def check(self) -> None:
        """The flight ends if the vehicle is far below that for some time, and nobody else lands it.

        Raises:
            FlightEnded: It is.
        """
        monitor = self._monitor
        if monitor.unexpected_mode or monitor.altitude_m >= self._too_low_m:
            self._since_s = None
        elif self._since_s is None:
            self._since_s = monitor.link_up_s
        elif monitor.link_up_s - self._since_s > _SUNK_S:
            raise flight_ended.sank(monitor.altitude_m, self._lowest_m, monitor.reason)

"""A vehicle that comes far below all that it is to fly has fallen, or is about to."""

from __future__ import annotations

from flight_replay.supervisor import flight_ended
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor

SUNK_M = 3.0
"""So far below a height that it was to keep, and half of that, a vehicle has sunk."""
_SUNK_S = 2.5
"""For so long: heartbeats tell within that of one that disarmed, and heights of an estimator that changes its
mind come back."""


class Sinking:
    """Whether a vehicle has been too low for long enough to have fallen."""

    def __init__(self, monitor: VehicleMonitor) -> None:
        self._monitor = monitor
        self._since_s: float | None = None

    def lasts(self, *, too_low: bool) -> bool:
        """Take in whether it is too low now; one that somebody else flies or lands does not fall."""
        if self._monitor.unexpected_mode or not too_low:
            self._since_s = None
        elif self._since_s is None:
            self._since_s = self._monitor.link_up_s
        return self._since_s is not None and self._monitor.link_up_s - self._since_s > _SUNK_S


class HeightWatch:
    """The vehicle's height, beside the lowest that it is to be at."""

    def __init__(self, monitor: VehicleMonitor, lowest_m: float) -> None:
        """Watch it where ``lowest_m`` above home, at which the vehicle is by now, allows."""
        self._monitor, self._lowest_m = monitor, lowest_m
        self._too_low_m = min(lowest_m / 2, lowest_m - SUNK_M)
        self._sinking = Sinking(monitor)

    def check(self) -> None:
        """The flight ends if the vehicle is far below that for some time, and nobody else lands it.

        Raises:
            FlightEnded: It is.
        """
        altitude_m = self._monitor.altitude_m
        if self._sinking.lasts(too_low=altitude_m < self._too_low_m):
            if self._monitor.armed is False:
                raise flight_ended.disarmed(self._monitor.reason)
            raise flight_ended.sank(altitude_m, self._lowest_m, self._monitor.reason)

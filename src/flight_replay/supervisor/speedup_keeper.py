"""Slows a simulator down whose targets come too late, because the machine is too busy for its speed.

At twenty times real time, 25 ms in which this process does not run are half a second of the vehicle's:
it brakes, and has to rejoin. A replay that takes longer is better than one with stalls.
"""

from __future__ import annotations

from flight_replay.events import Notice
from flight_replay.supervisor.vehicle_clock import VehicleClock
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor

_LATE_S = 0.3  # Vehicles brake by themselves 0.25 s after the last target, so for 0.05 s by then.
_TWICE_WITHIN_S = 5.0
_REAL_TIME = 1.0


class SpeedupKeeper:
    """Halves the speed of a simulator where targets come late twice within some seconds."""

    def __init__(self, monitor: VehicleMonitor, clock: VehicleClock, speedup: float | None) -> None:
        """Begin.

        Args:
            monitor: of the simulated vehicle.
            clock: of that vehicle; it is told of each change.
            speedup: how fast its clock is to run; None if that must not be changed.
        """
        self._monitor, self._clock, self._speedup = monitor, clock, speedup
        self._late_s = float("-inf")

    def target_sent(self, time_s: float, gap_s: float) -> None:
        """A target was sent at the vehicle's time ``time_s``, ``gap_s`` after the one before."""
        if gap_s <= _LATE_S or self._speedup is None or self._speedup <= _REAL_TIME:
            return
        twice = time_s - self._late_s <= _TWICE_WITHIN_S
        self._late_s = time_s
        if twice:
            self._late_s = float("-inf")
            self._slow_down(self._speedup, gap_s)

    def _slow_down(self, speedup: float, gap_s: float) -> None:
        # A busy machine may not reach the speed that was asked for.
        slower = max(round(min(speedup, self._clock.rate) / 2, 1), _REAL_TIME)
        self._speedup = slower
        self._monitor.vehicle.request_speedup(slower)
        self._clock.rate_changed(slower)
        self._monitor.emit(
            Notice(
                f" Targets came {gap_s:.1f} s apart: this machine is too busy for a speedup of {speedup:g}; "
                f"the simulator goes on at {slower:g}"
            )
        )

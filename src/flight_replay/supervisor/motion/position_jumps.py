"""Jumps of the vehicle's position estimate: a GPS that is wrong, or was, and the estimator follows it.

ArduPilot's estimator first doubts such a GPS, and believes it after some seconds; the position then steps,
and the vehicle, which did not move, flies on from there to a place that is as far from where it tells.
"""

from __future__ import annotations

from math import hypot

from flight_replay.events import VehicleState
from flight_replay.geometry.geodesy import ground_distance_m

_SMALLEST_M = 4.0  # Positions that are stamped with the time of the last GPS fix step by 0.2 s at 15 m/s.
_ACCELERATION_M_S2 = 10.0  # No copter changes its velocity faster, and hits what stops it but once.
_LONGEST_S = 1.0  # Between positions farther apart much may happen.
_RECENT_S = 10.0


def jump_m(before: VehicleState, now: VehicleState) -> float:
    """How far over the ground a position is from where its velocity leads; 0.0 if that may be no jump."""
    step_s = now.time_s - before.time_s
    if not 0.0 <= step_s <= _LONGEST_S:
        return 0.0
    speeds_m_s = (hypot(*state.velocity_m_s[:2]) for state in (before, now))
    unexplained_m = ground_distance_m(before, now) - max(speeds_m_s) * step_s
    return unexplained_m if unexplained_m > _SMALLEST_M + _ACCELERATION_M_S2 * step_s**2 / 4 else 0.0


class PositionJumps:
    """The largest jump of the last seconds."""

    def __init__(self) -> None:
        self._jump_m, self._time_s = 0.0, float("-inf")

    def observe(self, before: VehicleState, now: VehicleState) -> bool:
        """Take in two consecutive states: whether this is the first jump for some seconds."""
        jumped_m = jump_m(before, now)
        if jumped_m == 0.0:
            return False
        first = not self.latest(now.time_s)
        self._jump_m, self._time_s = jumped_m if first else max(jumped_m, self._jump_m), now.time_s
        return first

    def latest(self, time_s: float) -> str:
        """The jump of the seconds before a vehicle time, as the beginning of a sentence, or empty."""
        recent = time_s - self._time_s <= _RECENT_S
        return f"the vehicle's position estimate jumped by {self._jump_m:.0f} m" if recent else ""

"""Limits of speed and acceleration in any direction."""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.simulator.dynamics.shaping import kinematic_limit
from flight_replay.simulator.dynamics.vector import Vector


@dataclass(frozen=True, slots=True)
class PathLimits:
    """Speeds m/s, accelerations m/s², jerk m/s³ and snap m/s⁴ that legs are planned with."""

    speed_m_s: float
    speed_up_m_s: float
    speed_down_m_s: float
    accel_m_s2: float
    accel_z_m_s2: float
    jerk_m_s3: float
    snap_m_s4: float

    def speed_along(self, direction: Vector) -> float:
        """Highest speed in a direction."""
        return kinematic_limit(direction, self.speed_m_s, self.speed_up_m_s, self.speed_down_m_s)

    def accel_along(self, direction: Vector) -> float:
        """Highest acceleration in a direction."""
        return kinematic_limit(direction, self.accel_m_s2, self.accel_z_m_s2, self.accel_z_m_s2)

"""The position controller's target, and how it is moved.

Source: AC_PosControl.cpp (the input_... functions). A target has position, velocity and
acceleration, and is moved within limits of speed, acceleration and jerk. Metres north, east, up of
home.
"""

from __future__ import annotations

from math import hypot

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.shaping import (
    kinematic_limit,
    shape_position,
    shape_velocity,
    shape_velocity_xy,
    sqrt_controller,
)
from flight_replay.simulator.dynamics.vector import Vector

# AC_PosControl.h: POSCONTROL_OVERSPEED_GAIN_Z.
_OVERSPEED_GAIN = 2.0


class PositionTarget:
    """Target position, velocity and acceleration, and the limits of their motion."""

    __slots__ = (
        "_jerk", "_jerk_z", "accel_e", "accel_max", "accel_n", "accel_u", "accel_z_max", "dt", "e", "n",
        "speed_down", "speed_max", "speed_up", "u", "ve", "vn", "vu",
    )  # fmt: skip

    def __init__(self, limits: Limits, dt: float) -> None:
        self.dt = dt
        self.n = self.e = self.u = self.vn = self.ve = self.vu = 0.0
        self.accel_n = self.accel_e = self.accel_u = 0.0
        self.set_accelerations(limits)
        self.set_speeds(limits.wp_speed_m_s, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)

    def set_accelerations(self, limits: Limits) -> None:
        """Accelerations and jerk that parameters allow."""
        self.accel_max, self.accel_z_max = limits.wp_accel_m_s2, limits.wp_accel_z_m_s2
        self._jerk, self._jerk_z = limits.correction_jerk_m_s3, limits.correction_jerk_z_m_s3

    def set_speeds(self, level: float, up: float, down: float) -> None:
        """Highest speeds, m/s (set_max_speed_accel_xy, _z)."""
        self.speed_max, self.speed_up, self.speed_down = level, up, down

    def set_target(self, position: Vector, velocity: Vector, accel: Vector) -> None:
        """Set position, velocity and acceleration, which must be consistent."""
        self.n, self.e, self.u = position
        self.vn, self.ve, self.vu = velocity
        self.accel_n, self.accel_e, self.accel_u = accel

    def input_stop_xy(self) -> None:
        """Bring the horizontal target to rest (input_vel_accel_xy with zero velocity)."""
        self._move_xy()
        self._shape_xy(0.0, 0.0)

    def input_position(self, position: Vector) -> None:
        """Move the target to a position along the straight line there (input_pos_xyz)."""
        offset = position[0] - self.n, position[1] - self.e, position[2] - self.u
        length = hypot(*offset)
        speed = kinematic_limit(offset, self.speed_max, self.speed_up, self.speed_down)
        level, rise = 0.0, 0.0
        if length > 0:
            level, rise = speed * hypot(offset[0], offset[1]) / length, speed * abs(offset[2]) / length
        self._move_towards(position[0], position[1], level)
        self._move_z()
        bounds = (-rise, rise, self.accel_z_max, self._jerk_z)
        self.accel_u = shape_position(position[2] - self.u, self.vu, self.accel_u, bounds, self.dt)

    def input_position_xy(self, north: float, east: float) -> None:
        """Move the horizontal target to a position (input_pos_vel_accel_xy)."""
        self._move_towards(north, east, self.speed_max)

    def _move_towards(self, north: float, east: float, speed: float) -> None:
        self._move_xy()
        dn, de = north - self.n, east - self.e
        size = hypot(dn, de)
        wanted = 0.0
        if size > 0:
            gain = 0.5 * self._jerk / self.accel_max
            wanted = min(sqrt_controller(size, gain, 0.5 * self.accel_max, self.dt), speed) / size
        self._shape_xy(dn * wanted, de * wanted)

    def input_altitude(self, up_m: float) -> None:
        """Move the vertical target to an altitude (input_pos_vel_accel_z)."""
        self._move_z()
        gain = self._overspeed_gain()
        bounds = (-self.speed_down, self.speed_up, self.accel_z_max * gain, self._jerk_z * gain)
        self.accel_u = shape_position(up_m - self.u, self.vu, self.accel_u, bounds, self.dt)

    def input_climb_rate(self, rate_m_s: float) -> None:
        """Move the vertical target at a climb rate (input_vel_accel_z)."""
        self._move_z()
        gain = self._overspeed_gain()
        self.accel_u = shape_velocity(
            rate_m_s - self.vu, self.accel_u, self.accel_z_max * gain, self._jerk_z * gain, self.dt
        )

    def _shape_xy(self, vn: float, ve: float) -> None:
        """Accelerate the horizontal target towards a velocity."""
        self.accel_n, self.accel_e = shape_velocity_xy(
            (self.vn - vn, self.ve - ve), (self.accel_n, self.accel_e), self.accel_max, self._jerk, self.dt
        )

    def _move_xy(self) -> None:
        dt, half = self.dt, 0.5 * self.dt * self.dt
        self.n += self.vn * dt + self.accel_n * half
        self.e += self.ve * dt + self.accel_e * half
        self.vn += self.accel_n * dt
        self.ve += self.accel_e * dt

    def _move_z(self) -> None:
        dt = self.dt
        self.u += self.vu * dt + 0.5 * self.accel_u * dt * dt
        self.vu += self.accel_u * dt

    def _overspeed_gain(self) -> float:
        """More acceleration while the target is too fast (calculate_overspeed_gain)."""
        if self.vu < -self.speed_down:
            return -_OVERSPEED_GAIN * self.vu / self.speed_down
        return _OVERSPEED_GAIN * self.vu / self.speed_up if self.vu > self.speed_up else 1.0

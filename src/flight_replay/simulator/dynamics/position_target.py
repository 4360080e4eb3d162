"""The position controller's target, and how it is moved.

Source: AC_PosControl.cpp (the input_... functions). A target has position, velocity and
acceleration, and is moved within limits of speed, acceleration and jerk. Metres north, east, up of
home.
"""

from __future__ import annotations

from typing import Final

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.shaping import (
    kinematic_limit,
    shape_position,
    shape_velocity,
    shape_velocity_xy,
    sqrt_controller,
    step_towards,
    step_towards_xy,
)
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector, norm

# AC_PosControl.h: POSCONTROL_OVERSPEED_GAIN_Z.
_OVERSPEED_GAIN: Final = 2.0

Pair = tuple[float, float]


class PositionTarget(SnapshotPart):
    """Target position, velocity and acceleration, and the limits of their motion."""

    __slots__ = (
        "_jerk", "_jerk_z", "accel_e", "accel_max", "accel_n", "accel_u", "accel_z_max", "dt", "e",
        "excess", "n", "speed_down", "speed_max", "speed_up", "u", "ve", "vn", "vu",
    )  # fmt: skip

    def __init__(self, limits: Limits, dt: float) -> None:
        self.dt = dt
        self.n = self.e = self.u = self.vn = self.ve = self.vu = 0.0
        self.accel_n = self.accel_e = self.accel_u = 0.0
        self.excess: tuple[Pair, Pair, Pair] | None = None
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
        self._shape_xy((0.0, 0.0))

    def input_position_xy(self, north: float, east: float) -> None:
        """Move the horizontal target to a position (input_pos_vel_accel_xy)."""
        self._move_xy()
        self._shape_towards((north, east), self.speed_max)

    def input_altitude(self, up_m: float) -> None:
        """Move the vertical target to an altitude (input_pos_vel_accel_z)."""
        self._move_z()
        self.aim_altitude(up_m)

    def input_climb_rate(self, rate_m_s: float) -> None:
        """Move the vertical target at a climb rate (input_vel_accel_z)."""
        self._move_z()
        self.aim_climb_rate(rate_m_s)

    # What the input_... functions do, in two: accelerate the target, then, after the controllers, move it.

    def aim_position(self, position: Vector) -> None:
        """Accelerate towards a position along the straight line there (input_pos_xyz)."""
        offset = position[0] - self.n, position[1] - self.e, position[2] - self.u
        length = norm(*offset)
        speed = kinematic_limit(offset, self.speed_max, self.speed_up, self.speed_down)
        level, rise = 0.0, 0.0
        if length > 0:
            level, rise = speed * norm(offset[0], offset[1]) / length, speed * abs(offset[2]) / length
        self._shape_towards((position[0], position[1]), level)
        gain = self._overspeed_gain()
        bounds = (-rise, rise, self.accel_z_max * gain, self._jerk_z * gain)
        self.accel_u = shape_position(offset[2], self.vu, self.accel_u, bounds, self.dt)

    def aim_motion(self, position: Vector, velocity: Vector, accel: Vector) -> None:
        """Accelerate towards a goal that moves (input_pos_vel_accel_xy, _z)."""
        self._shape_towards(position[:2], self.speed_max, velocity[:2], accel[:2])
        self.aim_altitude(position[2], (velocity[2], accel[2]))

    def aim_velocity(self, velocity: Vector, accel: Vector) -> None:
        """Accelerate towards a velocity that changes (input_vel_accel_xy, _z)."""
        self._shape_xy(velocity[:2], accel[:2])
        self.aim_climb_rate(velocity[2], accel[2])

    def aim_acceleration(self, accel: Vector) -> None:
        """Change to an acceleration (input_accel_xy, _z)."""
        dt = self.dt
        now = self.accel_n, self.accel_e
        self.accel_n, self.accel_e = step_towards_xy(accel[:2], now, self._jerk * dt)
        self.accel_u = step_towards(accel[2], self.accel_u, self._jerk_z * self._overspeed_gain() * dt)

    def aim_altitude(self, up_m: float, feed: tuple[float, float] = (0.0, 0.0)) -> None:
        """Accelerate towards an altitude, which may move: velocity and acceleration are fed forward."""
        gain = self._overspeed_gain()
        bounds = (-self.speed_down, self.speed_up, self.accel_z_max * gain, self._jerk_z * gain)
        self.accel_u = shape_position(up_m - self.u, self.vu, self.accel_u, bounds, self.dt, feed=feed)

    def aim_climb_rate(self, rate_m_s: float, feed_m_s2: float = 0.0) -> None:
        """Accelerate towards a climb rate, which may change."""
        gain = self._overspeed_gain()
        accel, jerk = self.accel_z_max * gain, self._jerk_z * gain
        self.accel_u = shape_velocity(rate_m_s - self.vu, self.accel_u, accel, jerk, self.dt, feed=feed_m_s2)

    def move(self, before: Vector) -> None:
        """Move the target one step on, in which its acceleration has changed from what it was before."""
        an, ae, au = self.accel_n, self.accel_e, self.accel_u
        bn, be, bu = before
        dt, sixth = self.dt, self.dt * self.dt / 6.0
        self._move_xy_by(0.5 * (an + bn), 0.5 * (ae + be), (an - bn) * -0.5 * sixth, (ae - be) * -0.5 * sixth)
        self.u += self.vu * dt + (2.0 * bu + au) * sixth
        self.vu += 0.5 * (au + bu) * dt

    def _shape_towards(
        self, place: Pair, speed_max: float, velocity: Pair = (0.0, 0.0), accel: Pair = (0.0, 0.0)
    ) -> None:
        """Accelerate the horizontal target towards a place; ``speed_max`` limits the correction."""
        dn, de = place[0] - self.n, place[1] - self.e
        size = norm(dn, de)
        wanted = 0.0
        if size > 0:
            gain = 0.5 * self._jerk / self.accel_max
            wanted = min(sqrt_controller(size, gain, 0.5 * self.accel_max, self.dt), speed_max) / size
        self._shape_xy((dn * wanted + velocity[0], de * wanted + velocity[1]), accel)

    def _shape_xy(self, velocity: Pair, accel: Pair = (0.0, 0.0)) -> None:
        """Accelerate the horizontal target towards a velocity."""
        self.accel_n, self.accel_e = shape_velocity_xy(
            velocity,
            (self.vn, self.ve),
            (self.accel_n, self.accel_e),
            (self.accel_max, self._jerk),
            self.dt,
            feed=accel,
        )

    def _move_xy(self) -> None:
        self._move_xy_by(self.accel_n, self.accel_e)

    def _move_xy_by(self, an: float, ae: float, late_n: float = 0.0, late_e: float = 0.0) -> None:
        """Move on; where the lean is at its limit, not further ahead (update_pos_vel_accel_xy)."""
        dt, half = self.dt, 0.5 * self.dt * self.dt
        dn, de = self.vn * dt + an * half + late_n, self.ve * dt + ae * half + late_e
        if self.excess is not None:
            (n, e), (behind_n, behind_e), (slow_n, slow_e) = self.excess
            if dn * n + de * e > 0 and behind_n * n + behind_e * e > 0:
                dn = de = 0.0
            if an * n + ae * e > 0 and slow_n * n + slow_e * e > 0 and self.vn * n + self.ve * e >= 0:
                an = ae = 0.0
        self.n += dn
        self.e += de
        self.vn += an * dt
        self.ve += ae * dt

    def _move_z(self) -> None:
        dt = self.dt
        self.u += self.vu * dt + 0.5 * self.accel_u * dt * dt
        self.vu += self.accel_u * dt

    def _overspeed_gain(self) -> float:
        """More acceleration while the target is too fast (calculate_overspeed_gain)."""
        if self.vu < -self.speed_down:
            return -_OVERSPEED_GAIN * self.vu / self.speed_down
        return _OVERSPEED_GAIN * self.vu / self.speed_up if self.vu > self.speed_up else 1.0

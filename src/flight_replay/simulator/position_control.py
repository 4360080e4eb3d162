"""The position controller: targets to lean and throttle, as AC_PosControl.cpp does it.

Position errors become velocities (square-root P), velocity errors accelerations (PID across, P
vertically), and the targets' own velocity and acceleration are fed forward, so that a copter
lags only by what its attitude and the air take. Metres north, east, up of home.
"""

from __future__ import annotations

from math import exp, hypot, pi, sqrt, tan

from flight_replay.simulator.airframe import Airframe
from flight_replay.simulator.control import (
    clamp,
    kinematic_limit,
    limit_crosswise_first,
    shape_position,
    shape_stop,
    shape_velocity,
    sqrt_controller,
    stopping_distance,
)
from flight_replay.simulator.limits import GRAVITY_M_S2, Limits

# PSC_VELXY_FLTE, _FLTD, PSC_VELZ_FLTE: 5 Hz.
_FILTER_S = 1.0 / (2.0 * pi * 5.0)
# PSC_VELXY_IMAX.
_INTEGRATOR_MAX = 10.0
# AC_PosControl.h: POSCONTROL_STOPPING_DIST_UP_MAX and _DOWN_MAX.
_STOP_UP_M, _STOP_DOWN_M = 3.0, 2.0
# The throttle PID works in thousandths of throttle per cm/s².
_THROTTLE_PER_M_S2 = 0.1


class PositionControl:
    """Targets, limits and filters; ``update`` flies the airframe one step towards the targets."""

    __slots__ = (
        "_body", "_error_max", "_filter", "_fresh", "_integrator_e", "_integrator_n", "_jerk", "_jerk_z",
        "_lean_max", "_limited", "_limits", "_rate_e", "_rate_n", "_throttle_integral", "_verror_e",
        "_verror_n", "_verror_u", "accel_e", "accel_max", "accel_n", "accel_u", "accel_z_max", "dt", "e",
        "n", "speed_down", "speed_max", "throttle", "speed_up", "u", "ve", "vn", "vu",
    )  # fmt: skip

    def __init__(self, limits: Limits, body: Airframe) -> None:
        self._limits, self._body = limits, body
        self.dt = body.dt
        self._filter = 1.0 - exp(-self.dt / _FILTER_S)
        self._lean_max = GRAVITY_M_S2 * tan(limits.lean_angle_rad)
        self._jerk, self._jerk_z = limits.correction_jerk_m_s3, limits.correction_jerk_z_m_s3
        self.accel_max, self.accel_z_max = limits.wp_accel_m_s2, limits.wp_accel_z_m_s2
        self.set_speeds(limits.wp_speed_m_s, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)
        self._integrator_n = self._integrator_e = self._throttle_integral = 0.0
        self._error_max = self.throttle = 0.0
        self.limit_correction()
        self.rest_here()

    # limits and starts

    def use_limits(self, limits: Limits) -> None:
        """Go by other parameters from now on."""
        self._limits = limits
        self.accel_max, self.accel_z_max = limits.wp_accel_m_s2, limits.wp_accel_z_m_s2
        self._jerk, self._jerk_z = limits.correction_jerk_m_s3, limits.correction_jerk_z_m_s3

    def set_speeds(self, level: float, up: float, down: float) -> None:
        """Highest speeds of targets, m/s (set_max_speed_accel_xy, _z)."""
        self.speed_max, self.speed_up, self.speed_down = level, up, down

    def limit_correction(self) -> None:
        """Largest position error that is corrected (set_correction_speed_accel_xy)."""
        self._error_max = stopping_distance(self.speed_max, self._limits.position_p, self.accel_max)

    def rest_here(self) -> None:
        """Start from the airframe's position and velocity (init_xy_controller, init_z_controller)."""
        self.start_xy()
        self.start_z()

    def start_xy(self) -> None:
        """Targets at the airframe's horizontal position and velocity; its lean becomes the integral."""
        body = self._body
        self.n, self.e, self.vn, self.ve = body.n, body.e, body.vn, body.ve
        self.accel_n = self.accel_e = 0.0
        lean_n, lean_e = body.target_lean
        size = hypot(lean_n, lean_e) * GRAVITY_M_S2
        scale = GRAVITY_M_S2 * (self._lean_max / size if size > self._lean_max else 1.0)
        self._integrator_n, self._integrator_e = lean_n * scale, lean_e * scale
        self._verror_n = self._verror_e = self._rate_n = self._rate_e = 0.0
        self._fresh = True
        self._limited = (0.0, 0.0)

    def start_z(self) -> None:
        """Targets at the airframe's altitude, climb rate and acceleration."""
        body = self._body
        self.u, self.vu = body.u, body.vu
        self.accel_u = clamp(body.accel_u, -self.accel_z_max, self.accel_z_max)
        self._verror_u = 0.0
        surplus = body.throttle - self._limits.hover_throttle
        self._throttle_integral = surplus - _THROTTLE_PER_M_S2 * self._limits.accel_z_p * (
            self.accel_u - body.accel_u
        )

    def stopping_point(self) -> tuple[float, float, float]:
        """Where the airframe can come to rest (get_stopping_point_xy_cm, _z_cm)."""
        body = self._body
        speed = hypot(body.vn, body.ve)
        ahead = 0.0
        if speed > 0:
            ahead = (
                stopping_distance(min(speed, self.speed_max), self._limits.position_p, self.accel_max) / speed
            )
        rise = stopping_distance(body.vu, self._limits.position_z_p, self.accel_z_max)
        rise = clamp(rise, -_STOP_DOWN_M, _STOP_UP_M)
        return body.n + body.vn * ahead, body.e + body.ve * ahead, body.u + rise

    def start_at_stopping_point(self) -> tuple[float, float, float]:
        """Targets at rest at the stopping point, which is returned."""
        self.rest_here()
        self.n, self.e, self.u = self.stopping_point()
        self.vn = self.ve = self.vu = self.accel_u = 0.0
        return self.n, self.e, self.u

    # targets

    def set_target(self, position, velocity, accel) -> None:  # type: ignore[no-untyped-def]
        """Take over a consistent position, velocity and acceleration."""
        self.n, self.e, self.u = position
        self.vn, self.ve, self.vu = velocity
        self.accel_n, self.accel_e, self.accel_u = accel

    def shape_rest(self) -> None:
        """Bring the horizontal target to rest (input_vel_accel_xy with zero velocity)."""
        self._move_xy()
        self.accel_n, self.accel_e = shape_stop(
            (self.vn, self.ve), (self.accel_n, self.accel_e), self.accel_max, self._jerk, self.dt
        )

    def shape_to(self, place: tuple[float, float, float]) -> None:
        """Move the target to a place along the straight line there (input_pos_xyz)."""
        dn, de, du = place[0] - self.n, place[1] - self.e, place[2] - self.u
        flat = hypot(dn, de)
        length = hypot(flat, du)
        speed = kinematic_limit(dn, de, du, self.speed_max, self.speed_up, self.speed_down)
        self._move_xy()
        self._move_z()
        level, rise = (speed * flat / length, speed * abs(du) / length) if length > 0 else (0.0, 0.0)
        dn, de = place[0] - self.n, place[1] - self.e
        size = hypot(dn, de)
        wanted = 0.0
        if size > 0:
            gain = 0.5 * self._jerk / self.accel_max
            wanted = min(sqrt_controller(size, gain, 0.5 * self.accel_max, self.dt), level) / size
        self.accel_n, self.accel_e = shape_stop(
            (self.vn - dn * wanted, self.ve - de * wanted),
            (self.accel_n, self.accel_e),
            self.accel_max,
            self._jerk,
            self.dt,
        )
        bounds = (-rise, rise, self.accel_z_max, self._jerk_z)
        self.accel_u = shape_position(place[2] - self.u, self.vu, self.accel_u, bounds, self.dt)

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

    def shape_altitude(self, up_m: float) -> None:
        """Move the vertical target to an altitude (input_pos_vel_accel_z)."""
        self._move_z()
        gain = self._overspeed_gain()
        bounds = (-self.speed_down, self.speed_up, self.accel_z_max * gain, self._jerk_z * gain)
        self.accel_u = shape_position(up_m - self.u, self.vu, self.accel_u, bounds, self.dt)

    def shape_climb(self, rate_m_s: float) -> None:
        """Move the vertical target at a climb rate (input_vel_accel_z)."""
        self._move_z()
        gain = self._overspeed_gain()
        self.accel_u = shape_velocity(
            rate_m_s - self.vu,
            0.0,
            self.accel_u,
            self.accel_z_max * gain,
            self._jerk_z * gain,
            self.dt,
            total=True,
        )

    def _overspeed_gain(self) -> float:
        """More acceleration while the target is too fast (calculate_overspeed_gain)."""
        if self.vu < -self.speed_down:
            return -2.0 * self.vu / self.speed_down
        return 2.0 * self.vu / self.speed_up if self.vu > self.speed_up else 1.0

    # control

    def update(self) -> None:
        """One step of both controllers and of the airframe.

        Call it before the target moves on: target and airframe are then of the same time, whatever
        the step.
        """
        accel_n, accel_e = self._accel_wanted()
        self._body.step(accel_n, accel_e, self._throttle_wanted())

    def _accel_wanted(self) -> tuple[float, float]:
        """Horizontal acceleration for the airframe (update_xy_controller)."""
        limits, body, dt = self._limits, self._body, self.dt
        dn, de = self.n - body.n, self.e - body.e
        size = sqrt(dn * dn + de * de)
        if size > self._error_max:
            dn, de = dn * self._error_max / size, de * self._error_max / size
            self.n, self.e, size = body.n + dn, body.e + de, self._error_max
        gain = sqrt_controller(size, limits.position_p, self.accel_max, 0.0) / size if size > 0 else 0.0
        wn, we = dn * gain + self.vn - body.vn, de * gain + self.ve - body.ve
        if self._fresh:
            self._fresh = False
            self._verror_n, self._verror_e = wn, we
        else:
            part = self._filter
            step_n, step_e = (wn - self._verror_n) * part, (we - self._verror_e) * part
            self._verror_n += step_n
            self._verror_e += step_e
            self._rate_n += (step_n / dt - self._rate_n) * part
            self._rate_e += (step_e / dt - self._rate_e) * part
        self._integrate()
        p, d = limits.velocity_p, limits.velocity_d
        wanted = (
            self._verror_n * p + self._integrator_n + self._rate_n * d + self.accel_n,
            self._verror_e * p + self._integrator_e + self._rate_e * d + self.accel_e,
        )
        allowed = limit_crosswise_first(wanted, (self.vn, self.ve), self._lean_max)
        self._limited = (0.0, 0.0) if allowed is wanted else wanted
        return allowed

    def _integrate(self) -> None:
        """Integral of the velocity error, which does not grow against the lean limit (AC_PID_2D)."""
        step = self._limits.velocity_i * self.dt
        dn, de = self._verror_n * step, self._verror_e * step
        before = hypot(self._integrator_n, self._integrator_e)
        self._integrator_n += dn
        self._integrator_e += de
        most = before if dn * self._limited[0] + de * self._limited[1] > 0 else _INTEGRATOR_MAX
        size = hypot(self._integrator_n, self._integrator_e)
        if size > most:
            self._integrator_n *= most / size
            self._integrator_e *= most / size

    def _throttle_wanted(self) -> float:
        """Throttle for the airframe, 0 to 1 (update_z_controller)."""
        limits, body = self._limits, self._body
        wanted = sqrt_controller(self.u - body.u, limits.position_z_p, self.accel_z_max, 0.0)
        wanted = clamp(wanted, -self.speed_down, self.speed_up) + self.vu - body.vu
        self._verror_u += (wanted - self._verror_u) * self._filter
        error = self._verror_u * limits.velocity_z_p + self.accel_u - body.accel_u
        self._throttle_integral += _THROTTLE_PER_M_S2 * limits.accel_z_i * error * self.dt
        throttle = (
            limits.hover_throttle + self._throttle_integral + _THROTTLE_PER_M_S2 * limits.accel_z_p * error
        )
        self.throttle = clamp(throttle, 0.0, 1.0)
        return self.throttle

"""The position controller: targets to lean and throttle, as AC_PosControl.cpp does it.

Position errors become velocities (square-root P), velocity errors accelerations (PID across, P
vertically), and the targets' own velocity and acceleration are fed forward, so that a copter
lags only by what its attitude and the air take. Metres north, east, up of home.
"""

from __future__ import annotations

from math import exp, pi, sqrt, tan
from typing import Final

from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2, Limits
from flight_replay.simulator.dynamics.position_target import PositionTarget
from flight_replay.simulator.dynamics.shaping import (
    clamp,
    limit_accel_xy,
    sqrt_controller,
    stopping_distance,
)
from flight_replay.simulator.dynamics.vector import Vector, norm
from flight_replay.simulator.dynamics.velocity_pid import VelocityPid

# AC_PosControl.h: POSCONTROL_STOPPING_DIST_UP_MAX and _DOWN_MAX.
_STOP_UP_M: Final = 3.0
_STOP_DOWN_M: Final = 2.0
# PSC_VELZ_FLTE: 5 Hz.
_FILTER_Z_S: Final = 1.0 / (2.0 * pi * 5.0)
# The throttle PID works in thousandths of throttle per cm/s².
_THROTTLE_PER_M_S2: Final = 0.1


class PositionControl(PositionTarget):
    """The target and the controllers that follow it; ``update`` flies the airframe one step."""

    __slots__ = (
        "_airframe",
        "_alpha",
        "_error_down",
        "_error_max",
        "_error_up",
        "_lean_max",
        "_limits",
        "_pid",
        "_throttle_integral",
        "_velocity_error_u",
        "load",
        "throttle",
    )  # fmt: skip

    def __init__(self, limits: Limits, airframe: Airframe) -> None:
        super().__init__(limits, airframe.dt)
        self._airframe = airframe
        self._limits = limits
        self._pid = VelocityPid(self.dt, limits)
        self.use_step(self.dt)
        self.load = 0.0
        self._error_max = self._error_up = self._error_down = self.throttle = 0.0
        self.use_limits(limits)
        self.limit_correction()
        self.init_xyz()

    # limits and initial targets

    def use_limits(self, limits: Limits) -> None:
        """Use other limits from now on."""
        self._limits = limits
        self._lean_max = GRAVITY_M_S2 * tan(limits.lean_angle_rad)
        self.set_accelerations(limits)
        self._pid.use_step(self.dt, limits)

    def use_step(self, dt: float) -> None:
        """Use steps of another duration from now on."""
        self.dt = dt
        self._alpha = 1.0 - exp(-dt / _FILTER_Z_S)
        self._pid.use_step(dt, self._limits)

    def limit_correction(self) -> None:
        """Largest position errors that are corrected (set_correction_speed_accel_xy, _z)."""
        limits = self._limits
        self._error_max = stopping_distance(self.speed_max, limits.position_p, self.accel_max)
        self._error_up = stopping_distance(self.speed_up, limits.position_z_p, self.accel_z_max)
        self._error_down = stopping_distance(self.speed_down, limits.position_z_p, self.accel_z_max)

    def init_xyz(self) -> None:
        """Set the target to the airframe's position and velocity (init_xy_controller, init_z_controller)."""
        self.init_xy()
        self.init_z()

    def init_xy(self) -> None:
        """Set the target to the airframe's horizontal motion; the lean becomes the integral."""
        airframe = self._airframe
        self.n, self.e, self.vn, self.ve = airframe.n, airframe.e, airframe.vn, airframe.ve
        self.accel_n = self.accel_e = 0.0
        lean_n, lean_e = airframe.target_lean
        size = norm(lean_n, lean_e) * GRAVITY_M_S2
        scale = GRAVITY_M_S2 * (self._lean_max / size if size > self._lean_max else 1.0)
        self._pid.reset((lean_n * scale, lean_e * scale))

    def init_z(self) -> None:
        """Set the target to the airframe's altitude, climb rate and acceleration."""
        airframe, limits = self._airframe, self._limits
        self.u, self.vu = airframe.u, airframe.vu
        self.accel_u = clamp(airframe.accel_u, -self.accel_z_max, self.accel_z_max)
        self._velocity_error_u = 0.0
        flown = _THROTTLE_PER_M_S2 * limits.accel_z_p * (self.accel_u - airframe.accel_u)
        self._throttle_integral = airframe.throttle - limits.hover_throttle - flown

    def stopping_point(self) -> Vector:
        """Where the airframe can come to rest (get_stopping_point_xy_cm, _z_cm)."""
        airframe, limits = self._airframe, self._limits
        speed = norm(airframe.vn, airframe.ve)
        ahead = 0.0
        if speed > 0:
            ahead = stopping_distance(min(speed, self.speed_max), limits.position_p, self.accel_max) / speed
        rise = stopping_distance(airframe.vu, limits.position_z_p, self.accel_z_max)
        rise = clamp(rise, -_STOP_DOWN_M, _STOP_UP_M)
        return airframe.n + airframe.vn * ahead, airframe.e + airframe.ve * ahead, airframe.u + rise

    def init_at_stopping_point(self) -> Vector:
        """Set the target to rest at the stopping point, which is returned."""
        self.init_xy()
        self.n, self.e, _ = self.stopping_point()
        self.vn = self.ve = 0.0
        self.init_z_at_stopping_point()
        return self.n, self.e, self.u

    def init_z_at_stopping_point(self) -> None:
        """Set the vertical target to rest where the climb or descent can end."""
        self.init_z()
        self.u = self.stopping_point()[2]
        self.vu = self.accel_u = 0.0

    def drop_position_error(self) -> None:
        """Make the airframe's place the target (stop_pos_xy_stabilisation)."""
        self.n, self.e = self._airframe.n, self._airframe.e

    def drop_velocity_error(self) -> None:
        """Make the airframe's place and velocity the target (stop_vel_xy_stabilisation)."""
        self.drop_position_error()
        self.vn, self.ve = self._airframe.vn, self._airframe.ve
        self._pid.reset((0.0, 0.0))

    # control

    def update(self) -> None:
        """One step of both controllers and of the airframe.

        Call it before the target moves on: target and airframe are then of the same time, whatever
        the step.
        """
        self.limit_position_error()
        accel_n, accel_e = self._accel_wanted()
        self.throttle = self._throttle_wanted()
        self._airframe.step(accel_n, accel_e, self.throttle)

    def limit_position_error(self) -> None:
        """Bring the target to where its error is corrected fastest (AC_P_2D and AC_P_1D::update_all)."""
        airframe, error_max = self._airframe, self._error_max
        dn, de = self.n - airframe.n, self.e - airframe.e
        square = dn * dn + de * de
        if square > error_max * error_max:
            share = error_max / sqrt(square)
            self.n, self.e = airframe.n + dn * share, airframe.e + de * share
        error = self.u - airframe.u
        if not -self._error_down <= error <= self._error_up:
            self.u = airframe.u + clamp(error, -self._error_down, self._error_up)

    def _accel_wanted(self) -> tuple[float, float]:
        """Horizontal acceleration for the airframe (update_xy_controller)."""
        limits, airframe = self._limits, self._airframe
        dn, de = self.n - airframe.n, self.e - airframe.e
        size = norm(dn, de)
        gain = sqrt_controller(size, limits.position_p, self.accel_max, 0.0) / size if size > 0 else 0.0
        error = dn * gain + self.vn - airframe.vn, de * gain + self.ve - airframe.ve
        n, e = self._pid.advance(limits, error)
        n, e = n + self.accel_n, e + self.accel_e
        wanted = n, e
        self.load = norm(n, e) / self._lean_max
        allowed = limit_accel_xy(wanted, (self.vn, self.ve), self._lean_max)
        self.excess = None if allowed == wanted else (wanted, (dn, de), self._pid.error)
        self._pid.set_limited((0.0, 0.0) if allowed == wanted else wanted)
        return allowed

    def _throttle_wanted(self) -> float:
        """Throttle for the airframe, 0 to 1 (update_z_controller)."""
        limits, airframe = self._limits, self._airframe
        error = self.u - airframe.u
        wanted = sqrt_controller(error, limits.position_z_p, self.accel_z_max, 0.0) + self.vu - airframe.vu
        self._velocity_error_u += (wanted - self._velocity_error_u) * self._alpha
        error = self._velocity_error_u * limits.velocity_z_p + self.accel_u - airframe.accel_u
        self._throttle_integral += _THROTTLE_PER_M_S2 * limits.accel_z_i * error * self.dt
        correction = self._throttle_integral + _THROTTLE_PER_M_S2 * limits.accel_z_p * error
        return clamp(limits.hover_throttle + correction, 0.0, 1.0)

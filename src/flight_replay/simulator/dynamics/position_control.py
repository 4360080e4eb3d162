"""The position controller: targets to lean and throttle, as AC_PosControl.cpp does it.

Position errors become velocities (square-root P), velocity errors accelerations (PID across, P
vertically), and the targets' own velocity and acceleration are fed forward, so that a copter
lags only by what its attitude and the air take. Metres north, east, up of home.
"""

from __future__ import annotations

from math import exp, hypot, sqrt, tan

from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2, Limits
from flight_replay.simulator.dynamics.position_target import Targets
from flight_replay.simulator.dynamics.shaping import (
    clamp,
    limit_crosswise_first,
    sqrt_controller,
    stopping_distance,
)
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.dynamics.velocity_pid import FILTER_S, VelocityPid

# AC_PosControl.h: POSCONTROL_STOPPING_DIST_UP_MAX and _DOWN_MAX.
_STOP_UP_M, _STOP_DOWN_M = 3.0, 2.0
# The throttle PID works in thousandths of throttle per cm/s².
_THROTTLE_PER_M_S2 = 0.1


class PositionControl(Targets):
    """Targets and what follows them; ``update`` flies the airframe one step."""

    __slots__ = (
        "_body", "_error_max", "_lean_max", "_limits", "_part", "_pid", "_throttle_integral", "_verror_u",
        "throttle",
    )  # fmt: skip

    def __init__(self, limits: Limits, body: Airframe) -> None:
        super().__init__(limits, body.dt)
        self._body = body
        self._part = 1.0 - exp(-self.dt / FILTER_S)
        self._pid = VelocityPid(self.dt)
        self._error_max = self.throttle = 0.0
        self.use_limits(limits)
        self.limit_correction()
        self.rest_here()

    # limits and starts

    def use_limits(self, limits: Limits) -> None:
        """Go by other parameters from now on."""
        self._limits = limits
        self._lean_max = GRAVITY_M_S2 * tan(limits.lean_angle_rad)
        self.set_accelerations(limits)

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
        self._pid.restart((lean_n * scale, lean_e * scale))

    def start_z(self) -> None:
        """Targets at the airframe's altitude, climb rate and acceleration."""
        body, limits = self._body, self._limits
        self.u, self.vu = body.u, body.vu
        self.accel_u = clamp(body.accel_u, -self.accel_z_max, self.accel_z_max)
        self._verror_u = 0.0
        flown = _THROTTLE_PER_M_S2 * limits.accel_z_p * (self.accel_u - body.accel_u)
        self._throttle_integral = body.throttle - limits.hover_throttle - flown

    def stopping_point(self) -> Vector:
        """Where the airframe can come to rest (get_stopping_point_xy_cm, _z_cm)."""
        body, limits = self._body, self._limits
        speed = hypot(body.vn, body.ve)
        ahead = 0.0
        if speed > 0:
            ahead = stopping_distance(min(speed, self.speed_max), limits.position_p, self.accel_max) / speed
        rise = stopping_distance(body.vu, limits.position_z_p, self.accel_z_max)
        rise = clamp(rise, -_STOP_DOWN_M, _STOP_UP_M)
        return body.n + body.vn * ahead, body.e + body.ve * ahead, body.u + rise

    def start_at_stopping_point(self) -> Vector:
        """Targets at rest at the stopping point, which is returned."""
        self.start_xy()
        self.n, self.e, _ = self.stopping_point()
        self.vn = self.ve = 0.0
        self.start_z_at_stopping_point()
        return self.n, self.e, self.u

    def start_z_at_stopping_point(self) -> None:
        """The vertical target at rest where the climb or descent can end."""
        self.start_z()
        self.u = self.stopping_point()[2]
        self.vu = self.accel_u = 0.0

    # control

    def update(self) -> None:
        """One step of both controllers and of the airframe.

        Call it before the target moves on: target and airframe are then of the same time, whatever
        the step.
        """
        accel_n, accel_e = self._accel_wanted()
        self.throttle = self._throttle_wanted()
        self._body.step(accel_n, accel_e, self.throttle)

    def _accel_wanted(self) -> tuple[float, float]:
        """Horizontal acceleration for the airframe (update_xy_controller)."""
        limits, body = self._limits, self._body
        dn, de = self.n - body.n, self.e - body.e
        size = sqrt(dn * dn + de * de)
        if size > self._error_max:
            dn, de = dn * self._error_max / size, de * self._error_max / size
            self.n, self.e, size = body.n + dn, body.e + de, self._error_max
        gain = sqrt_controller(size, limits.position_p, self.accel_max, 0.0) / size if size > 0 else 0.0
        error = dn * gain + self.vn - body.vn, de * gain + self.ve - body.ve
        n, e = self._pid.advance(limits, error)
        wanted = n + self.accel_n, e + self.accel_e
        allowed = limit_crosswise_first(wanted, (self.vn, self.ve), self._lean_max)
        self._pid.limited((0.0, 0.0) if allowed is wanted else wanted)
        return allowed

    def _throttle_wanted(self) -> float:
        """Throttle for the airframe, 0 to 1 (update_z_controller)."""
        limits, body = self._limits, self._body
        wanted = sqrt_controller(self.u - body.u, limits.position_z_p, self.accel_z_max, 0.0)
        wanted = clamp(wanted, -self.speed_down, self.speed_up) + self.vu - body.vu
        self._verror_u += (wanted - self._verror_u) * self._part
        error = self._verror_u * limits.velocity_z_p + self.accel_u - body.accel_u
        self._throttle_integral += _THROTTLE_PER_M_S2 * limits.accel_z_i * error * self.dt
        surplus = self._throttle_integral + _THROTTLE_PER_M_S2 * limits.accel_z_p * error
        return clamp(limits.hover_throttle + surplus, 0.0, 1.0)

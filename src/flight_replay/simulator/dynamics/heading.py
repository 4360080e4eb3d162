"""The heading: the attitude controller's target, and the airframe that turns after it.

Sources: AC_AttitudeControl.cpp (input_shaping_angle, update_ang_vel_target_from_att_error) and
AC_AttitudeControl_Multi.cpp (the yaw rate's PID, gains of SITL's copter.parm). How fast the "+" frame
of SITL turns per output of the PID was fitted to its logs: 13.9 rad/s² and a drag of 1.95/s. The
yaw is weak: at 60 degrees/s the nose is 6 degrees behind the target.
"""

from __future__ import annotations

from math import exp, pi, radians
from typing import Final

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.shaping import clamp, sqrt_controller, step_towards, wrap_pi
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart

# ATC_ANG_YAW_P, ATC_RAT_YAW_P, _I and _FLTE, and the largest yaw acceleration that an angle asks for.
_ANGLE_P: Final = 4.5
_RATE_P: Final = 0.3
_RATE_I: Final = 0.02
_FILTER_S: Final = 1.0 / (2.0 * pi * 2.5)
_ANGLE_ACCEL_RAD_S2: Final = radians(120.0)
_RAD_S2_PER_OUTPUT: Final = 13.9
_DRAG_PER_S: Final = 1.95
# Angle, rad, and rate, rad/s, below which a turn is over.
_NO_TURN: Final = 1e-5


class Heading(SnapshotPart):
    """``target`` is turned within limits of rate and acceleration; ``yaw`` follows it. Radians."""

    __slots__ = ("_dt", "_error", "_integral", "_limits", "_rate", "_smooth", "_target_rate", "target", "yaw")

    def __init__(self, limits: Limits, yaw_rad: float, dt: float) -> None:
        self.yaw = self.target = yaw_rad
        self._target_rate = self._rate = self._error = self._integral = 0.0
        self.use_limits(limits)
        self.use_step(dt)

    def use_limits(self, limits: Limits) -> None:
        """Use other limits from now on."""
        self._limits = limits

    def use_step(self, dt: float) -> None:
        """Use steps of another duration from now on."""
        self._dt = dt
        self._smooth = 1.0 - exp(-dt / _FILTER_S)

    def turn_towards(self, yaw_rad: float, rate_rad_s: float) -> None:
        """Turn one step to a heading, with a rate fed forward (input_thrust_vector_heading)."""
        limits, dt = self._limits, self._dt
        error = wrap_pi(yaw_rad - self.target)
        if abs(error) < _NO_TURN and abs(self._target_rate) < _NO_TURN and rate_rad_s == 0.0:
            self._target_rate = 0.0
            self._follow()
            return
        accel = limits.yaw_accel_rad_s2
        wanted = sqrt_controller(error, 1.0 / max(limits.attitude_input_s, 0.01), accel, dt)
        self._turn_target(self._within_slew(self._within_slew(rate_rad_s) + wanted))

    def turn_at(self, rate_rad_s: float) -> None:
        """Turn one step with a rate (input_thrust_vector_rate_heading)."""
        self._turn_target(self._within_slew(rate_rad_s))

    def _within_slew(self, rate: float) -> float:
        slew = self._limits.yaw_slew_rad_s
        return clamp(rate, -slew, slew) if slew > 0 else rate

    def _turn_target(self, rate: float) -> None:
        accel, dt = self._limits.yaw_accel_rad_s2, self._dt
        self._target_rate = step_towards(rate, self._target_rate, accel * dt) if accel > 0 else rate
        self.target = wrap_pi(self.target + self._target_rate * dt)
        self._follow()

    def _follow(self) -> None:
        """Turn the airframe: an angle error becomes a rate, a rate error an output, and that a torque."""
        dt, behind = self._dt, wrap_pi(self.target - self.yaw)
        if abs(behind) < _NO_TURN and abs(self._rate) < _NO_TURN and self._target_rate == 0.0:
            return
        wanted = self._target_rate + sqrt_controller(behind, _ANGLE_P, _ANGLE_ACCEL_RAD_S2, dt)
        self._error += (wanted - self._rate - self._error) * self._smooth
        self._integral += _RATE_I * self._error * dt
        output = clamp(_RATE_P * self._error + self._integral, -1.0, 1.0)
        self._rate += (_RAD_S2_PER_OUTPUT * output - _DRAG_PER_S * self._rate) * dt
        self.yaw = wrap_pi(self.yaw + self._rate * dt)

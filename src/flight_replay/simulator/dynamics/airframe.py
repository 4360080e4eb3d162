"""The airframe that ArduPilot's SITL flies: its motion under lean and throttle, in still or moving air.

Sources: AC_AttitudeControl.cpp (input_thrust_vector_heading, input_shaping_angle, ang_vel_limit: how the
lean follows its target, forward and to the right by themselves) and AP_MotorsMulticopter.cpp (the throttle
filter); forces are in ``aerodynamics``. Leans are kept as the horizontal part of the thrust over its
vertical part, north and east; positions are metres north, east and up of home.
"""

from __future__ import annotations

from math import atan, cos, exp, pi, sin
from typing import Final

from flight_replay.simulator.dynamics.aerodynamics import Air
from flight_replay.simulator.dynamics.body_turns import lean_rate, turn_between
from flight_replay.simulator.dynamics.heading import Heading
from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2, Limits
from flight_replay.simulator.dynamics.shaping import sqrt_controller, step_towards
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector, norm

# AC_PosControl.h: POSCONTROL_THROTTLE_CUTOFF_FREQ_HZ.
_THROTTLE_FILTER_S: Final = 1.0 / (2.0 * pi * 2.0)
# Rounds in which the lean against a wind is found: each leaves a fraction of the error.
_WIND_ROUNDS: Final = 8
# Time by which the airframe's lean follows the attitude controller's target, 15 to 30 ms in SITL's logs.
_LEAN_LAG_S: Final = 0.016


class Airframe(SnapshotPart):
    """Position, velocity, lean and heading; ``step`` moves them on."""

    __slots__ = (
        "_air",
        "_heading_unit",
        "_lean_decay",
        "_limits",
        "_rate_forward",
        "_rate_right",
        "_target_e",
        "_target_n",
        "_target_unit",
        "_target_yaw",
        "_throttle_decay",
        "accel_u",
        "dt",
        "e",
        "heading",
        "lean_e",
        "lean_n",
        "n",
        "on_ground",
        "throttle",
        "u",
        "ve",
        "vn",
        "vu",
        "yaw",
    )  # fmt: skip

    def __init__(
        self,
        limits: Limits,
        position_m: Vector,
        yaw_rad: float,
        air: Air,
        dt: float,
    ) -> None:
        self.n, self.e, self.u = position_m
        self.vn = self.ve = self.vu = 0.0
        self.lean_n = self.lean_e = 0.0
        self._target_n = self._target_e = self._rate_forward = self._rate_right = 0.0
        self.heading = Heading(limits, yaw_rad, dt)
        self.yaw = self._target_yaw = yaw_rad
        self._heading_unit = self._target_unit = cos(yaw_rad), sin(yaw_rad)
        self.on_ground = self.u <= 0
        self.throttle = 0.0 if self.on_ground else limits.hover_throttle
        self.accel_u = 0.0
        self._limits = limits
        self._air = air
        self.use_step(dt)

    def lean_into_wind(self) -> None:
        """Lean as a hover needs it that has lasted."""
        hover = (0.0, 0.0, 0.0)
        for _ in range(_WIND_ROUNDS):
            an, ae, _ = self._air.acceleration(
                hover, (self.lean_n, self.lean_e), self._heading_unit, GRAVITY_M_S2
            )
            self.lean_n -= an / GRAVITY_M_S2
            self.lean_e -= ae / GRAVITY_M_S2
        self._target_n, self._target_e = self.lean_n, self.lean_e

    def use_step(self, dt: float) -> None:
        """Use steps of another duration from now on."""
        self.dt = dt
        self._throttle_decay = exp(-dt / _THROTTLE_FILTER_S)
        self._lean_decay = exp(-dt / _LEAN_LAG_S)
        self.heading.use_step(dt)

    def use_limits(self, limits: Limits) -> None:
        """Use other limits from now on."""
        self._limits = limits
        self.heading.use_limits(limits)

    def use_wind(self, wind_m_s: Vector) -> None:
        """Use another wind from now on."""
        self._air.wind_m_s = wind_m_s

    @property
    def attitude_rad(self) -> tuple[float, float, float]:
        """Roll, pitch and yaw."""
        c, s = cos(self.yaw), sin(self.yaw)
        forward = self.lean_n * c + self.lean_e * s
        right = self.lean_e * c - self.lean_n * s
        pitch = -atan(forward)
        return atan(right * cos(pitch)), pitch, self.yaw

    @property
    def target_lean(self) -> tuple[float, float]:
        """The lean that the attitude controller aims at now."""
        return self._target_n, self._target_e

    def step(self, accel_n: float, accel_e: float, throttle: float) -> None:
        """Move one step on, with a demanded horizontal acceleration, m/s², and a throttle, 0 to 1."""
        dt = self.dt
        lean_n, lean_e = self.lean_n, self.lean_e
        self._lean_towards(accel_n / GRAVITY_M_S2, accel_e / GRAVITY_M_S2)
        mean_lean = 0.5 * (lean_n + self.lean_n), 0.5 * (lean_e + self.lean_e)
        self.throttle = throttle + (self.throttle - throttle) * self._throttle_decay
        vn, ve, vu = self.vn, self.ve, self.vu
        # The throttle is divided by the cosine of the lean (AC_AttitudeControl::get_throttle_boosted).
        lift = GRAVITY_M_S2 * self.throttle / self._limits.hover_throttle
        an, ae, self.accel_u = self._air.acceleration((vn, ve, vu), mean_lean, self._heading_unit, lift)
        self.vn, self.ve, self.vu = vn + an * dt, ve + ae * dt, vu + self.accel_u * dt
        self.n += 0.5 * dt * (vn + self.vn)
        self.e += 0.5 * dt * (ve + self.ve)
        self.u += 0.5 * dt * (vu + self.vu)
        self.on_ground = self.u <= 0.0 and self.vu <= 0.0
        if self.on_ground:
            self._rest()

    def _rest(self) -> None:
        """Stay at rest on the ground (SIM_Aircraft.cpp: GROUND_BEHAVIOR_NO_MOVEMENT)."""
        self.u = 0.0
        self.vn = self.ve = self.vu = 0.0
        self.accel_u = 0.0

    def _lean_towards(self, lean_n: float, lean_e: float) -> None:
        """Move the attitude target with limited rate and acceleration, and the lean after it."""
        dt = self.dt
        c, s = self._target_unit
        target = self._target_n * c + self._target_e * s, self._target_e * c - self._target_n * s
        turn = turn_between(target, (lean_n * c + lean_e * s, lean_e * c - lean_n * s))
        forward, right = lean_rate(target, self._next_turn_rates(turn))
        rate_n, rate_e = forward * c - right * s, forward * s + right * c
        # The lean follows a target that moves on evenly, so that its lag is the same in steps of any length.
        decay = self._lean_decay
        late_n, late_e = rate_n * _LEAN_LAG_S, rate_e * _LEAN_LAG_S
        behind_n, behind_e = self._target_n - late_n - self.lean_n, self._target_e - late_e - self.lean_e
        self._target_n += rate_n * dt
        self._target_e += rate_e * dt
        self.lean_n = self._target_n - late_n - behind_n * decay
        self.lean_e = self._target_e - late_e - behind_e * decay

    def _next_turn_rates(self, turn: tuple[float, float]) -> tuple[float, float]:
        """Next rates, forward and to the right, rad/s, for a turn that is wanted; a limit of 0 is none."""
        forward = self._next_turn_rate(turn[0], self._rate_forward)
        right = self._next_turn_rate(turn[1], self._rate_right)
        rate_max = self._limits.lean_rate_rad_s
        if rate_max > 0:
            share = min(1.0, rate_max / max(norm(forward, right), 1e-9))
            forward, right = forward * share, right * share
        self._rate_forward, self._rate_right = forward, right
        return forward, right

    def _next_turn_rate(self, error: float, rate: float) -> float:
        """Next rate about one axis of the body (input_shaping_angle)."""
        limits, dt = self._limits, self.dt
        accel_max = limits.lean_accel_rad_s2
        wanted = sqrt_controller(error, 1.0 / max(limits.attitude_input_s, 0.01), accel_max, dt)
        return step_towards(wanted, rate, accel_max * dt) if accel_max > 0 else wanted

    def turn_towards(self, yaw_rad: float, rate_rad_s: float) -> None:
        """Turn towards a heading, with a rate fed forward."""
        self.heading.turn_towards(yaw_rad, rate_rad_s)
        self._turned()

    def turn_at(self, rate_rad_s: float) -> None:
        """Turn with a rate."""
        self.heading.turn_at(rate_rad_s)
        self._turned()

    def _turned(self) -> None:
        yaw, target = self.heading.yaw, self.heading.target
        if yaw != self.yaw:
            self.yaw, self._heading_unit = yaw, (cos(yaw), sin(yaw))
        if target != self._target_yaw:
            self._target_yaw, self._target_unit = target, (cos(target), sin(target))

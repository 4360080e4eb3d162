"""GUIDED: flying after targets of position, velocity, acceleration and heading (mode_guided.cpp).

Each step accelerates the controller's target towards what was sent (input shaping), flies the
airframe, and moves both on: between messages the goal goes on with its velocity and acceleration.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import hypot

from flight_replay.simulator.dynamics.auto_yaw import YawMode
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.flight_control import FlightControl
from flight_replay.simulator.flight.submode import SubMode

_ZERO: Vector = (0.0, 0.0, 0.0)
# GUID_OPTIONS, and the least that GUID_TIMEOUT means (ModeGuided::get_timeout_ms).
_NO_POSITION_CORRECTION, _NO_VELOCITY_CORRECTION = 16, 32
_SHORTEST_TIMEOUT_S = 0.1
# Share of the largest lean near which steps are divided, how long after, and into how many.
_NEAR_LIMIT, _CALM_S, _PARTS = 0.75, 0.5, 5


@dataclass(frozen=True, slots=True)
class GuidedTarget:
    """What a station asks for; None is what it leaves to the copter. North, east, up."""

    position_m: Vector | None = None
    velocity_m_s: Vector | None = None
    acceleration_m_s2: Vector | None = None
    yaw_rad: float | None = None
    yaw_rate_rad_s: float | None = None
    yaw_is_relative: bool = False
    keeps_heading: bool = False
    """Whether it leaves the heading to other commands, as ArduCopter 3.3 does."""


class GuidedSubMode(SubMode, ABC):
    """A controller of GUIDED, and the target that it follows."""

    def __init__(self, flight: FlightControl, *, keeps_heading: bool = False) -> None:
        """Begin from the present position and velocity (pva_control_start)."""
        self._flight, self._age_s, self._calm_s = flight, 0.0, _CALM_S
        self._position_m, self._velocity_m_s, self._acceleration_m_s2 = _ZERO, _ZERO, _ZERO
        limits, control = flight.limits, flight.control
        control.set_speeds(limits.wp_speed_m_s, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)
        control.limit_correction()
        control.init_xyz()
        if not keeps_heading:
            flight.auto_yaw.set_default_mode()
        elif flight.auto_yaw.mode is not YawMode.FIXED:
            flight.auto_yaw.hold()

    def accept(self, target: GuidedTarget, late_s: float = 0.0) -> None:
        """Follow a target that was sent ``late_s`` ago."""
        self._age_s = late_s
        self._position_m = target.position_m or _ZERO
        self._velocity_m_s = target.velocity_m_s or _ZERO
        self._acceleration_m_s2 = target.acceleration_m_s2 or _ZERO
        self._turn(target, late_s)
        if late_s != 0:
            self._advance_goal(late_s)

    def _turn(self, target: GuidedTarget, late_s: float) -> None:
        """Turn as the target has it (set_yaw_state); without a heading, as WP_YAW_BEHAVIOR has it."""
        auto_yaw, yaw, rate = self._flight.auto_yaw, target.yaw_rad, target.yaw_rate_rad_s
        if target.keeps_heading:
            return
        if yaw is not None and target.yaw_is_relative:
            auto_yaw.set_fixed_yaw(yaw, relative=True)
        elif yaw is not None:
            auto_yaw.set_yaw_and_rate(yaw + (rate or 0.0) * late_s, rate or 0.0)
        elif rate is not None:
            auto_yaw.set_rate(rate)
        else:
            auto_yaw.set_default_mode()

    @property
    def goal(self) -> GuidedTarget:
        """Where the target is by now, of what this controller follows."""
        return GuidedTarget(self._position_m, self._velocity_m_s, self._acceleration_m_s2)

    @property
    def timed_out(self) -> bool:
        """Whether the last target is too old."""
        return self._age_s > max(self._flight.limits.guided_timeout_s, _SHORTEST_TIMEOUT_S)

    def step(self) -> None:
        """Fly one step; in smaller ones where the lean is near its limit, and every detail counts."""
        flight = self._flight
        if flight.control.load > _NEAR_LIMIT:
            self._calm_s = 0.0
        if self._calm_s >= _CALM_S:
            self._step()
            return
        dt = flight.airframe.dt
        flight.use_step(dt / _PARTS)
        for _ in range(_PARTS):
            self._step()
        flight.use_step(dt)
        self._calm_s += dt

    def _step(self) -> None:
        """Accelerate the controller's target, fly, and move both on."""
        flight = self._flight
        if self.timed_out:
            self._velocity_m_s = self._acceleration_m_s2 = _ZERO
            flight.auto_yaw.stop_turning()
        control = flight.control
        before = control.accel_n, control.accel_e, control.accel_u
        self._aim()
        control.update()
        control.move(before)
        flight.auto_yaw.update()
        self._age_s += control.dt
        self._advance_goal(control.dt)

    @abstractmethod
    def _aim(self) -> None:
        """Accelerate the controller's target."""

    def _advance_goal(self, dt: float) -> None:
        """Let the goal go on with its velocity and acceleration."""
        velocity, accel = self._velocity_m_s, self._acceleration_m_s2
        n, e, u = self._position_m
        vn, ve, vu = velocity
        an, ae, au = accel
        half = 0.5 * dt * dt
        self._position_m = n + vn * dt + an * half, e + ve * dt + ae * half, u + vu * dt + au * half
        self._velocity_m_s = vn + an * dt, ve + ae * dt, vu + au * dt

    def _leave_uncorrected(self) -> None:
        """Give up position and velocity errors, if GUID_OPTIONS says so (stop_pos_xy_stabilisation)."""
        options = int(self._flight.limits.guided_options)
        if options & _NO_VELOCITY_CORRECTION:
            self._flight.control.drop_velocity_error()
        elif options & _NO_POSITION_CORRECTION:
            self._flight.control.drop_position_error()


class GuidedPosition(GuidedSubMode):
    """Fly to a position (pos_control_run)."""

    def accept(self, target: GuidedTarget, late_s: float = 0.0) -> None:
        """Fly to the target's position, and rest there."""
        super().accept(target, late_s)
        self.done = False

    @property
    def goal(self) -> GuidedTarget:
        """Where it flies to."""
        return GuidedTarget(position_m=self._position_m)

    def _aim(self) -> None:
        self._flight.control.aim_position(self._position_m)

    def step(self) -> None:
        """Fly one step."""
        super().step()
        airframe, (n, e, u) = self._flight.airframe, self._position_m
        off_m = hypot(airframe.n - n, airframe.e - e, airframe.u - u)
        self.done = off_m <= self._flight.limits.wp_radius_m


class GuidedMotion(GuidedSubMode):
    """Fly after a position that moves (posvelaccel_control_run)."""

    def _aim(self) -> None:
        control = self._flight.control
        options = int(self._flight.limits.guided_options)
        if options & (_NO_POSITION_CORRECTION | _NO_VELOCITY_CORRECTION):
            self._position_m = (control.n, control.e, self._position_m[2])
        if options & _NO_VELOCITY_CORRECTION:
            self._velocity_m_s = (control.vn, control.ve, self._velocity_m_s[2])
        control.aim_motion(self._position_m, self._velocity_m_s, self._acceleration_m_s2)
        self._leave_uncorrected()


class GuidedVelocity(GuidedSubMode):
    """Fly at a velocity that may change (velaccel_control_run)."""

    @property
    def goal(self) -> GuidedTarget:
        """The velocity by now, and its acceleration."""
        return GuidedTarget(None, self._velocity_m_s, self._acceleration_m_s2)

    def _aim(self) -> None:
        control = self._flight.control
        if int(self._flight.limits.guided_options) & _NO_VELOCITY_CORRECTION:
            self._velocity_m_s = (control.vn, control.ve, self._velocity_m_s[2])
        control.aim_velocity(self._velocity_m_s, self._acceleration_m_s2)
        self._leave_uncorrected()


class GuidedAcceleration(GuidedSubMode):
    """Fly with an acceleration, and come to rest when it is not repeated (accel_control_run)."""

    @property
    def goal(self) -> GuidedTarget:
        """The acceleration."""
        return GuidedTarget(acceleration_m_s2=self._acceleration_m_s2)

    def _aim(self) -> None:
        if self.timed_out:
            self._flight.control.aim_velocity(_ZERO, _ZERO)
        else:
            self._flight.control.aim_acceleration(self._acceleration_m_s2)
            self._leave_uncorrected()

    def _advance_goal(self, dt: float) -> None:
        """An acceleration stays."""


def submode_for(target: GuidedTarget) -> type[GuidedSubMode] | None:
    """The controller that flies what a target has; None if there is none, and the copter stops.

    With a velocity an acceleration may be left out; with a position alone it must be.
    """
    has_position, has_velocity = target.position_m is not None, target.velocity_m_s is not None
    if has_velocity:
        return GuidedMotion if has_position else GuidedVelocity
    if target.acceleration_m_s2 is not None:
        return None if has_position else GuidedAcceleration
    return GuidedPosition if has_position else None

"""Waypoint navigation: which leg the target is on, and how legs join.

Source: AC_WPNav/AC_WPNav.cpp (4.1 to 4.7). A waypoint is "fast" when the next one is known while
it is flown to; else the copter stops there. Metres north, east, up of home.
"""

from __future__ import annotations

from math import hypot

from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import MIN_SPEED_M_S, Limits
from flight_replay.simulator.dynamics.position_control import PositionControl
from flight_replay.simulator.dynamics.vector import Vector, minus
from flight_replay.simulator.navigation.hermite import Ends
from flight_replay.simulator.navigation.leg_blending import StraightLegs
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.scurve import SCurve
from flight_replay.simulator.navigation.spline import Spline
from flight_replay.simulator.navigation.target_clock import TrackClock

_NOWHERE = (0.0, 0.0, 0.0)


class WaypointNavigation:
    """The target on its way through waypoints; ``advance`` moves it and flies the airframe after it."""

    def __init__(self, limits: Limits, body: Airframe, control: PositionControl) -> None:
        self._limits, self._body, self._control = limits, body, control
        self.start()

    def start(self, speed_m_s: float = 0.0) -> None:
        """Begin at rest at the stopping point (wp_and_spline_init)."""
        limits, control = self._limits, self._control
        self._speed = max(speed_m_s if speed_m_s > 0 else limits.wp_speed_m_s, MIN_SPEED_M_S)
        control.set_speeds(self._speed, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)
        control.limit_correction()
        self._origin = self.destination = control.start_at_stopping_point()
        self._legs = StraightLegs()
        self._spline: Spline | None = None
        self._next_spline: Spline | None = None
        self._assumed_speed = 0.0
        self.clock = TrackClock()
        self._unused_s = 0.0
        self.reached = True
        self.fast = False

    def use_limits(self, limits: Limits) -> None:
        """Go by other parameters from now on."""
        self._limits = limits

    @property
    def _path_limits(self) -> PathLimits:
        limits, control = self._limits, self._control
        return PathLimits(
            control.speed_max,
            control.speed_up,
            control.speed_down,
            limits.wp_accel_m_s2,
            limits.wp_accel_z_m_s2,
            limits.path_jerk_m_s3,
            limits.path_snap_m_s4,
        )

    # speeds

    def set_speed(self, speed_m_s: float) -> None:
        """Change the horizontal speed, now and for legs to come (set_speed_xy)."""
        if speed_m_s < MIN_SPEED_M_S:
            return
        self._speed = speed_m_s
        control = self._control
        control.set_speeds(speed_m_s, control.speed_up, control.speed_down)
        control.limit_correction()
        self._replan()

    def set_speed_up(self, speed_m_s: float) -> None:
        """Change the climb speed."""
        self._control.set_speeds(self._control.speed_max, speed_m_s, self._control.speed_down)
        self._replan()

    def set_speed_down(self, speed_m_s: float) -> None:
        """Change the descent speed."""
        self._control.set_speeds(self._control.speed_max, self._control.speed_up, abs(speed_m_s))
        self._replan()

    def _replan(self) -> None:
        """Give this leg and the next the new speeds (update_track_with_speed_accel_limits)."""
        limits = self._path_limits
        for leg in (self._spline or self._legs.current, self._next_spline or self._legs.following):
            leg.change_speed(limits)

    # legs

    def fly_straight(self, destination: Vector) -> None:
        """Fly a straight leg from the last destination (set_wp_destination)."""
        if not self.reached:
            self.start(self._speed)
        legs = self._legs
        self._origin, self.destination = self.destination, destination
        if self._spline is not None:
            leg = SCurve(minus(destination, self._origin), self._path_limits)
            leg.limit_origin_speed(self._spline.speed)
            legs.begin(leg, previous=SCurve())
        elif self.fast and self._next_spline is None and not legs.following.finished:
            legs.begin(legs.following, previous=legs.current)
        else:
            legs.begin(SCurve(minus(destination, self._origin), self._path_limits), previous=legs.current)
        self._spline = None
        self.fast = self.reached = False

    def then_straight(self, destination: Vector) -> None:
        """Announce a straight leg after this one (set_wp_destination_next)."""
        self._legs.following = leg = SCurve(minus(destination, self.destination), self._path_limits)
        if self._spline is not None:
            speed = leg.limit_origin_speed(self._spline.destination_speed)
            self._spline.limit_destination_speed(speed)
        self._next_spline = None
        self.fast = True

    def fly_spline(self, destination: Vector, arriving: Vector) -> None:
        """Fly a spline leg from the last destination, ending along ``arriving`` (set_spline_destination)."""
        if not self.reached:
            self.start(self._speed)
        leaving = self._leaving if self.fast else _NOWHERE
        self._origin, self.destination = self.destination, destination
        speed = self._target_speed
        self._spline = Spline(Ends(self._origin, destination, leaving, arriving), self._path_limits)
        self._spline.speed = speed
        self.fast = any(arriving)
        self.reached = False

    def then_spline(self, destination: Vector, arriving: Vector) -> None:
        """Announce a spline leg after this one (set_spline_destination_next)."""
        ends = Ends(self.destination, destination, self._leaving, arriving)
        self._next_spline = spline = Spline(ends, self._path_limits, self._assumed_speed)
        self._assumed_speed = spline.destination_speed
        self.fast = True
        (self._spline or self._legs.current).limit_destination_speed(spline.origin_speed)

    @property
    def _target_speed(self) -> float:
        control = self._control
        return self._spline.speed if self._spline else hypot(control.vn, control.ve, control.vu)

    @property
    def _leaving(self) -> Vector:
        """Tangent with which this leg hands over to a spline."""
        return self._spline.arriving if self._spline else minus(self.destination, self._origin)

    # motion

    def advance(self) -> None:
        """Fly the airframe one step towards the target, and move the target on (update_wpnav)."""
        control = self._control
        dt = self.clock.advance(self._limits, control, self._body) + self._unused_s
        control.update()
        accel = _NOWHERE
        if self._spline is not None:
            position, velocity = self._spline.advance(dt)
            finished, unused_s = self._spline.finished, self._spline.unused_s
        else:
            turn = self._limits if self.fast else None
            position, velocity, accel, finished = self._legs.advance(dt, self._origin, turn)
            unused_s = self._legs.unused_s
        # What a step has left at a fast waypoint belongs to the next leg.
        self._unused_s = unused_s if self.fast else 0.0
        control.set_target(position, velocity, accel)
        if finished and not self.reached:
            self.reached = self.fast or self._within_radius()

    def _within_radius(self) -> bool:
        n, e, u = self.destination
        body = self._body
        return hypot(body.n - n, body.e - e, body.u - u) <= self._limits.wp_radius_m

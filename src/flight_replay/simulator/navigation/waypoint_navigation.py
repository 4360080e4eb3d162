"""Waypoint navigation: the leg that the target is on, and how it joins the next.

Source: AC_WPNav/AC_WPNav.cpp (4.1 to 4.7). A waypoint is "fast" when the next one is known before
the copter is there; otherwise the copter stops. Metres north, east, up of home.
"""

from __future__ import annotations

from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import MIN_SPEED_M_S, Limits
from flight_replay.simulator.dynamics.position_control import PositionControl
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector, minus, norm
from flight_replay.simulator.navigation.hermite import Ends
from flight_replay.simulator.navigation.leg_blending import StraightLegs
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.scurve import SCurve
from flight_replay.simulator.navigation.spline import Spline
from flight_replay.simulator.navigation.track_scaler import TrackScaler

_ZERO = (0.0, 0.0, 0.0)


class WaypointNavigation(SnapshotPart):
    """The target that flies through the waypoints; ``advance`` moves it and flies the airframe after it.

    ``has_error`` says whether ArduPilot has reported an internal error: see ``SCurve``.
    """

    def __init__(self, limits: Limits, airframe: Airframe, control: PositionControl) -> None:
        self._limits, self._airframe, self._control = limits, airframe, control
        self.has_error = False
        self.start()

    def start(self, speed_m_s: float = 0.0) -> None:
        """Start at rest at the stopping point (wp_and_spline_init)."""
        limits, control = self._limits, self._control
        self._speed = max(speed_m_s if speed_m_s > 0 else limits.wp_speed_m_s, MIN_SPEED_M_S)
        control.set_speeds(self._speed, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)
        control.limit_correction()
        self._origin = self.destination = control.init_at_stopping_point()
        self._legs = StraightLegs()
        self._spline: Spline | None = None
        self._next_spline: Spline | None = None
        self._assumed_speed = 0.0
        self.track_scaler = TrackScaler(self._airframe.vu)
        self.unused_s = 0.0
        self.reached = True
        self.fast_waypoint = False

    def use_limits(self, limits: Limits) -> None:
        """Use other limits from now on."""
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
        """Plan this leg and the next with the new speeds (update_track_with_speed_accel_limits)."""
        limits = self._path_limits
        for leg in (self._spline or self._legs.current, self._next_spline or self._legs.following):
            leg.change_speed(limits)
        self._note_errors()

    # legs

    def set_wp_destination(self, destination: Vector) -> None:
        """Fly a straight leg from the last destination."""
        if not self.reached:
            self.start(self._speed)
        legs = self._legs
        self._origin, self.destination = self.destination, destination
        if self._spline is not None:
            leg = SCurve(minus(destination, self._origin), self._path_limits)
            leg.limit_origin_speed(self._spline.speed)
            legs.begin(leg, previous=SCurve())
        elif self.fast_waypoint and self._next_spline is None and not legs.following.finished:
            legs.begin(legs.following, previous=legs.current)
        else:
            legs.begin(SCurve(minus(destination, self._origin), self._path_limits), previous=legs.current)
        self._spline = None
        self.fast_waypoint = self.reached = False
        self._note_errors()

    def set_wp_destination_next(self, destination: Vector) -> None:
        """Set the destination of a straight leg after this one."""
        self._legs.following = leg = SCurve(minus(destination, self.destination), self._path_limits)
        if self._spline is not None:
            speed = leg.limit_origin_speed(self._spline.destination_speed)
            self._spline.limit_destination_speed(speed)
        self._next_spline = None
        self.fast_waypoint = True
        self._note_errors()

    def set_spline_destination(self, destination: Vector, destination_tangent: Vector) -> None:
        """Fly a spline leg from the last destination, ending along ``destination_tangent``."""
        if not self.reached:
            self.start(self._speed)
        origin_tangent = self._origin_tangent if self.fast_waypoint else _ZERO
        self._origin, self.destination = self.destination, destination
        speed = self._target_speed
        self._spline = Spline(
            Ends(self._origin, destination, origin_tangent, destination_tangent), self._path_limits
        )
        self._spline.speed = speed
        self.fast_waypoint = any(destination_tangent)
        self.reached = False

    def set_spline_destination_next(self, destination: Vector, destination_tangent: Vector) -> None:
        """Set the destination of a spline leg after this one."""
        ends = Ends(self.destination, destination, self._origin_tangent, destination_tangent)
        self._next_spline = spline = Spline(ends, self._path_limits, self._assumed_speed)
        self._assumed_speed = spline.destination_speed
        self.fast_waypoint = True
        (self._spline or self._legs.current).limit_destination_speed(spline.origin_speed)
        self._note_errors()

    def _note_errors(self) -> None:
        """Keep in mind that ArduPilot has reported an internal error on a leg."""
        self.has_error = self.has_error or self._legs.current.has_error or self._legs.following.has_error

    @property
    def _target_speed(self) -> float:
        control = self._control
        return self._spline.speed if self._spline else norm(control.vn, control.ve, control.vu)

    @property
    def _origin_tangent(self) -> Vector:
        """Tangent at which a spline after this leg begins."""
        return self._spline.destination_tangent if self._spline else minus(self.destination, self._origin)

    # motion

    def advance(self) -> None:
        """Fly the airframe one step towards the target, and move the target on (update_wpnav)."""
        control = self._control
        control.limit_position_error()
        dt = self.track_scaler.advance(self._limits, control, self._airframe) + self.unused_s
        control.update()
        accel = (0.0, 0.0, 0.0)
        if self._spline is not None:
            position, velocity = self._spline.advance(dt)
            finished, unused_s = self._spline.finished, self._spline.unused_s
        else:
            corner = self._limits if self.fast_waypoint else None
            position, velocity, accel, finished = self._legs.advance(dt, self._origin, corner)
            unused_s = self._legs.unused_s
        # The rest of a step at a fast waypoint is the next leg's; the target goes straight on till then.
        self.unused_s = rest_s = unused_s if self.fast_waypoint else 0.0
        if rest_s > 0.0:
            (n, e, u), (vn, ve, vu) = position, velocity
            position = (n + vn * rest_s, e + ve * rest_s, u + vu * rest_s)
        control.set_target(position, velocity, accel)
        if finished and not self.reached:
            self.reached = self.fast_waypoint or self._within_radius()

    def _within_radius(self) -> bool:
        n, e, u = self.destination
        airframe = self._airframe
        return norm(airframe.n - n, airframe.e - e, airframe.u - u) <= self._limits.wp_radius_m

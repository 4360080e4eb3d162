"""Flying circles, as LOITER_TURNS does (AC_WPNav/AC_Circle.cpp, ModeAuto::circle_movetoedge_start)."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, radians, sin, sqrt

from flight_replay.simulator.dynamics.shaping import clamp, step_towards
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.flight_control import FlightControl
from flight_replay.simulator.flight.submode import SubMode

# AC_CIRCLE_ANGULAR_ACCEL_MIN; farther than this from the edge the copter flies there first.
_MIN_ANGULAR_ACCEL = radians(2.0)
_NEAR_EDGE_M = 3.0
# Within this distance of the centre, or within the circle, it keeps its heading on the way.
_NEAR_CENTRE_M = 5.0


class Circle(SubMode):
    """Fly to the nearest point of a circle, then around it; ``turns`` below 0 go counterclockwise."""

    def __init__(self, flight: FlightControl, centre: Vector, radius_m: float, turns: float) -> None:
        self._flight = flight
        self._centre, self._radius_m, self._turns = centre, radius_m, turns
        self.done = False
        self._turned = self._rate = self._angle = 0.0
        edge = self._edge()
        n, e, u = flight.position
        self._on_edge = hypot(n - edge[0], e - edge[1], u - edge[2]) <= _NEAR_EDGE_M
        if self._on_edge:
            self._begin()
            return
        flight.navigation.set_wp_destination(edge)
        within = hypot(n - centre[0], e - centre[1]) <= max(radius_m, _NEAR_CENTRE_M)
        flight.auto_yaw.begin_leg(keeps_heading=within)

    def _edge(self) -> Vector:
        """The point of the circle nearest to where the copter can stop; behind it from the centre."""
        n, e, u = self._centre
        stop = self._flight.control.stopping_point()
        dn, de = stop[0] - n, stop[1] - e
        distance = hypot(dn, de)
        if distance == 0:
            yaw = self._flight.airframe.yaw
            dn, de, distance = -cos(yaw), -sin(yaw), 1.0
        return n + self._radius_m * dn / distance, e + self._radius_m * de / distance, u

    def _begin(self) -> None:
        flight = self._flight
        flight.control.init_at_stopping_point()
        n, e, _ = flight.position
        self._angle = atan2(e - self._centre[1], n - self._centre[0])

    def step(self) -> None:
        """Fly one step to the edge, or along it."""
        if self._on_edge:
            self._turn()
            return
        navigation = self._flight.navigation
        navigation.advance()
        self._flight.auto_yaw.update()
        if navigation.reached:
            self._on_edge = True
            self._begin()

    def _turn(self) -> None:
        """Move the angle on, and the target after it (AC_Circle::update)."""
        flight = self._flight
        control = flight.control
        control.update()
        fastest, accel = self._angular_limits()
        self._rate = step_towards(fastest, self._rate, accel * control.dt)
        self._angle += self._rate * control.dt
        self._turned += abs(self._rate) * control.dt
        n, e, _ = self._centre
        control.input_position_xy(
            n + self._radius_m * cos(self._angle), e + self._radius_m * sin(self._angle)
        )
        control.input_climb_rate(0.0)
        flight.auto_yaw.look_at((n, e))
        self.done = self._turned >= 2.0 * pi * abs(self._turns)

    def _angular_limits(self) -> tuple[float, float]:
        """Angular velocity, rad/s, and acceleration, rad/s² (AC_Circle::calc_velocities)."""
        control, radius = self._flight.control, self._radius_m
        rate = abs(self._flight.limits.circle_rate_rad_s) * (1.0 if self._turns >= 0 else -1.0)
        if radius <= 0:
            return rate, max(abs(rate), _MIN_ANGULAR_ACCEL)
        fastest = min(control.speed_max, sqrt(0.5 * control.accel_max * radius)) / radius
        return clamp(rate, -fastest, fastest), max(control.accel_max / radius, _MIN_ANGULAR_ACCEL)

"""A spline leg as ArduCopter flies it: a cubic Hermite curve, and the speed along it.

Source: AP_Math/SplineCurve.cpp. The curve's parameter t runs over 0..1; a tangent at an end is the
vector that the neighbouring items give (see ``waypoint_navigation``). The speed is limited by half
of the acceleration across the track and by half of it along the track, with a stop or the next
leg's speed ahead.
"""

from __future__ import annotations

from math import sqrt
from typing import Final

from flight_replay.simulator.dynamics.shaping import clamp
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector, norm
from flight_replay.simulator.navigation.hermite import Coefficients, Ends, hermite
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.spline_end import motion_at_rest

# SplineCurve.cpp: LATERAL_ACCEL_SCALER and TANGENTIAL_ACCEL_SCALER.
_LATERAL_SHARE: Final = 0.5
_TANGENTIAL_SHARE: Final = 0.5
_ZERO = (0.0, 0.0, 0.0)
# Of t: a longer step is taken in smaller ones.
_LONG_STEP: Final = 0.05
_SMALL_STEPS: Final = 8
# On board, with steps of 2.5 ms, a step goes by the speed from before it, and that by where the step
# before began: half a step late while the speed grows, one and a half while it falls. A stop comes
# up to 0.1 s sooner for it.
_ACCEL_DELAY_S: Final = 0.00125
_DECEL_DELAY_S: Final = 0.00375
# A 32-bit curve that is flown through ends some 0.01 mm off its destination.
_REST_M_S: Final = 0.002


class _CurvePoint(SnapshotPart):
    """A point that moves along a curve: position, unit tangent, and the speed and acceleration allowed there.

    ``tangent`` is the length of the derivative by t, m, and ``tangent_growth`` how that grows with t.
    """

    __slots__ = (
        "_coefficients", "accel", "jerk", "position", "speed_max", "tangent", "tangent_growth", "unit",
    )  # fmt: skip

    def __init__(self, coefficients: Coefficients, t: float, limits: PathLimits) -> None:
        self._coefficients, self.jerk = coefficients, 0.0
        self.move_to(t, limits)

    def move_to(self, t: float, limits: PathLimits) -> None:
        """Move to a parameter, 0 to 1."""
        (n0, e0, u0), (n1, e1, u1), (n2, e2, u2), (n3, e3, u3) = self._coefficients
        self.position = (
            n0 + t * (n1 + t * (n2 + t * n3)),
            e0 + t * (e1 + t * (e2 + t * e3)),
            u0 + t * (u1 + t * (u2 + t * u3)),
        )
        vn = n1 + t * (2.0 * n2 + 3.0 * t * n3)
        ve = e1 + t * (2.0 * e2 + 3.0 * t * e3)
        vu = u1 + t * (2.0 * u2 + 3.0 * t * u3)
        an, ae, au = 2.0 * n2 + 6.0 * t * n3, 2.0 * e2 + 6.0 * t * e3, 2.0 * u2 + 6.0 * t * u3
        self.tangent = tangent = norm(vn, ve, vu)
        if tangent > 0:
            vn, ve, vu = vn / tangent, ve / tangent, vu / tangent
        else:
            # At rest the second derivative points the way, or where there is none, the third.
            self.jerk = 6.0 * norm(n3, e3, u3)
            vn, ve, vu = _direction(an, ae, au) or _direction(n3, e3, u3) or _ZERO
        self.unit = (vn, ve, vu)
        self.tangent_growth = along = an * vn + ae * ve + au * vu
        self.accel = _TANGENTIAL_SHARE * limits.accel_along(self.unit)
        self.speed_max = limits.speed_along(self.unit)
        an, ae, au = an - along * vn, ae - along * ve, au - along * vu
        across = norm(an, ae, au)
        if across > 0 and tangent > 0:
            allowed = _LATERAL_SHARE * limits.accel_along((an, ae, au))
            self.speed_max = min(self.speed_max, tangent * sqrt(allowed / across))

    def t_step(self, distance: float) -> float:
        """How much t grows over a distance from here, by the tangent and its growth."""
        square = self.tangent * self.tangent + 2.0 * self.tangent_growth * distance
        mean = 0.5 * (self.tangent + sqrt(square)) if square > 0 else 0.5 * self.tangent
        return distance / mean if mean > 0 else (6.0 * distance / self.jerk) ** (1.0 / 3.0)


def _direction(n: float, e: float, u: float) -> Vector | None:
    """Unit vector along a vector; None without one."""
    length = norm(n, e, u)
    return (n / length, e / length, u / length) if length > 0 else None


def _speed_after(speed: float, before: float, after: float, change: float) -> float:
    """Speed after a step in which it changes by ``change`` at most.

    What is allowed goes from ``before`` to ``after``: the speed falls while it is above that and grows while
    it is below. It turns where they cross, within the step. On board it turns with a step of 2.5 ms; with one
    of 20 ms that would leave an error of speed, by where steps happen to fall, up to the next bend.
    """
    low, high = speed - change, speed + change
    if before < speed:
        if after <= low:
            return low
        turns = (speed - before) / (speed - before + after - low)
        return min(after, high - 2.0 * change * turns)
    if after >= high:
        return high
    turns = (before - speed) / (before - speed + high - after)
    return max(after, low + 2.0 * change * turns)


class Spline(SnapshotPart):
    """Motion along one spline leg; ``speed``, m/s, is what it has now, and may be set to begin with.

    ``assumed_speed`` is the speed at the destination, m/s, that the origin speed is planned for
    before the real one is known: ArduPilot leaves that of the spline planned before.
    """

    __slots__ = (
        "_coefficients", "_destination", "_ends", "_limits", "_point", "_rest", "_t",
        "destination_speed", "destination_tangent", "finished", "origin_speed", "speed", "unused_s",
    )  # fmt: skip

    def __init__(self, ends: Ends, limits: PathLimits, assumed_speed: float = 0.0) -> None:
        self._ends, self._destination = ends, ends.destination
        self._limits = limits
        self._rest: tuple[Vector, float] | None = None
        self._t = self.unused_s = 0.0
        self.finished = ends.origin == ends.destination
        self.destination_tangent = _ZERO if self.finished else ends.destination_tangent
        self.origin_speed = self.destination_speed = self.speed = 0.0
        self._point: _CurvePoint | None = None
        self._coefficients = hermite(ends)
        if self.finished:
            return
        self._point = _CurvePoint(self._coefficients, 0.0, limits)
        self.destination_speed = assumed_speed
        self.origin_speed = self._allowed_speed(self._point, self._distance(self._point))
        self.destination_speed = 0.0
        if any(ends.destination_tangent):
            self.destination_speed = _CurvePoint(self._coefficients, 1.0, limits).speed_max

    def change_speed(self, limits: PathLimits) -> None:
        """Fly the rest of the leg with other limits (SplineCurve::set_speed_accel)."""
        self._limits = limits

    def limit_destination_speed(self, speed: float) -> None:
        """End not faster than ``speed`` (SplineCurve::set_destination_speed_max)."""
        self.destination_speed = min(self.destination_speed, speed)

    def _distance(self, point: _CurvePoint) -> float:
        """How far it is from a point straight to the destination, m."""
        n, e, u = point.position
        dn, de, du = self._destination
        return norm(dn - n, de - e, du - u)

    def _allowed_speed(self, point: _CurvePoint, distance: float) -> float:
        """What curve and limits allow at a point, so far from the destination with its own speed."""
        braking = sqrt(2.0 * point.accel * distance + self.destination_speed * self.destination_speed)
        return min(point.speed_max, braking)

    def _t_after(self, point: _CurvePoint, distance: float) -> float:
        """The parameter t a distance on; in small steps, as on board, where that is much of the curve.

        A tangent of centimetres, as on a leg straight back, says little of the curve further on.
        """
        step = point.t_step(distance)
        if step < _LONG_STEP:
            return self._t + step
        t, part = self._t, distance / _SMALL_STEPS
        ahead = _CurvePoint(self._coefficients, t, self._limits)
        for _ in range(_SMALL_STEPS):
            ahead.move_to(min(t, 1.0), self._limits)
            t += ahead.t_step(part)
        return t

    def _velocity_at_rest(self, point: _CurvePoint, dt: float) -> Vector:
        """Velocity at the end ``point``; the speed falls on, for the next leg to start with."""
        if self._rest is None:
            stops = not any(self._ends.destination_tangent)
            self._rest = motion_at_rest(self._ends, self._limits) if stops else (_ZERO, _REST_M_S)
        (n, e, u), rest = self._rest
        accel = _TANGENTIAL_SHARE * self._limits.accel_along((n, e, u)) or point.accel
        self.speed = speed = max(self.speed - accel * dt, rest)
        return n * speed, e * speed, u * speed

    def advance(self, dt: float) -> tuple[Vector, Vector]:
        """Target position and velocity ``dt`` seconds on.

        Source: SplineCurve::advance_target_along_track.
        """
        point, speed = self._point, self.speed
        if point is None:
            self.speed = 0.0
            return self._destination, _ZERO
        if self.finished:
            return self._destination, self._velocity_at_rest(point, dt)
        left, change = self._distance(point), point.accel * dt
        before = self._allowed_speed(point, left)
        ahead = self._allowed_speed(point, max(0.0, left - speed * dt))
        next_speed = clamp(ahead, speed - change, speed + change)
        delay_s = _DECEL_DELAY_S if next_speed < speed else _ACCEL_DELAY_S
        # With the track's time nearly at a standstill the delay would be the longer of both.
        distance = max(0.0, 0.5 * (speed + next_speed) * dt + (speed - next_speed) * delay_s)
        self._t = self._t_after(point, distance)
        beyond = self._t - 1.0
        point.move_to(min(self._t, 1.0), self._limits)
        if beyond >= 0.0:
            self.unused_s = min(beyond * point.tangent / speed, dt) if speed > 0 else 0.0
            dt -= self.unused_s
            self._t = 1.0
            self.finished = True
        after = self._allowed_speed(point, self._distance(point))
        self.speed = speed = _speed_after(speed, before, after, point.accel * dt)
        n, e, u = point.unit if point.tangent > 0 or not self.finished else _ZERO
        return point.position, (n * speed, e * speed, u * speed)

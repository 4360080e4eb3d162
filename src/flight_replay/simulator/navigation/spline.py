"""A spline leg as ArduCopter flies it: a cubic Hermite curve, and the speed along it.

Source: AP_Math/SplineCurve.cpp. The curve runs over 0..1; a tangent at an end is the vector that
the neighbouring items give (see ``wpnav``). The speed is limited by half of the acceleration
across the track and by half of it along the track, with a stop or the next leg's speed ahead.
"""

from __future__ import annotations

from math import hypot, sqrt

from flight_replay.simulator.dynamics.shaping import clamp
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.navigation.hermite import Coefficients, Ends, hermite
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.spline_end import motion_at_rest

# SplineCurve.cpp: LATERAL_ACCEL_SCALER, TANGENTIAL_ACCEL_SCALER and SPLINE_FACTOR.
_ACROSS_SHARE = 0.5
_ALONG_SHARE = 0.5
_NOWHERE = (0.0, 0.0, 0.0)
_FOREVER_S = 1e6
# Of t: a longer step is taken in smaller ones.
_LONG_STEP, _SMALL_STEPS = 0.05, 8
# On board, with steps of 2.5 ms, a step goes by the speed from before it, and that by where the
# step before began. A stop comes the sooner for it, by as much as 0.1 s.
_STARTS_LATE_S, _BRAKES_LATE_S = 0.00125, 0.00375
# A 32-bit curve that is flown through ends some 0.01 mm off its destination.
_REST_M_S = 0.002


class _Place:
    """Where on a curve: position, unit tangent, and the speed and acceleration allowed along it.

    ``rate`` and ``bend`` are the ground covered per unit of t, m, and how that grows with t.
    """

    __slots__ = ("accel", "bend", "jerk", "position", "rate", "speed_max", "unit")

    def __init__(self, coefficients: Coefficients, t: float, limits: PathLimits) -> None:
        (n0, e0, u0), (n1, e1, u1), (n2, e2, u2), (n3, e3, u3) = coefficients
        self.position = (
            n0 + t * (n1 + t * (n2 + t * n3)),
            e0 + t * (e1 + t * (e2 + t * e3)),
            u0 + t * (u1 + t * (u2 + t * u3)),
        )
        vn = n1 + t * (2.0 * n2 + 3.0 * t * n3)
        ve = e1 + t * (2.0 * e2 + 3.0 * t * e3)
        vu = u1 + t * (2.0 * u2 + 3.0 * t * u3)
        an, ae, au = 2.0 * n2 + 6.0 * t * n3, 2.0 * e2 + 6.0 * t * e3, 2.0 * u2 + 6.0 * t * u3
        self.rate = rate = sqrt(vn * vn + ve * ve + vu * vu)
        if rate > 0:
            vn, ve, vu = vn / rate, ve / rate, vu / rate
        else:
            # At rest the second derivative points the way, or where there is none, the third.
            self.jerk = 6.0 * hypot(n3, e3, u3)
            vn, ve, vu = _direction(an, ae, au) or _direction(n3, e3, u3) or _NOWHERE
        self.unit = (vn, ve, vu)
        self.bend = along = an * vn + ae * ve + au * vu
        self.accel = _ALONG_SHARE * limits.accel_along(self.unit)
        self.speed_max = limits.speed_along(self.unit)
        an, ae, au = an - along * vn, ae - along * ve, au - along * vu
        across = sqrt(an * an + ae * ae + au * au)
        if across > 0 and rate > 0:
            allowed = _ACROSS_SHARE * limits.accel_along((an, ae, au))
            self.speed_max = min(self.speed_max, rate * sqrt(allowed / across))

    def time_for(self, distance: float) -> float:
        """How much of t a distance takes from here, by the rate and its growth."""
        square = self.rate * self.rate + 2.0 * self.bend * distance
        mean = 0.5 * (self.rate + sqrt(square)) if square > 0 else 0.5 * self.rate
        return distance / mean if mean > 0 else (6.0 * distance / self.jerk) ** (1.0 / 3.0)


def _direction(n: float, e: float, u: float) -> Vector | None:
    """Unit vector along a vector; None without one."""
    length = hypot(n, e, u)
    return (n / length, e / length, u / length) if length > 0 else None


class Spline:
    """Motion along one spline leg; ``speed``, m/s, is what it has now, and may be set to begin with.

    ``assumed_speed`` is what the look ahead from the origin takes for the destination's speed
    before that is known: ArduPilot leaves the value of the spline planned before (m/s).
    """

    __slots__ = (
        "_coefficients", "_destination", "_ends", "_limits", "_place", "_rest",
        "arriving", "destination_speed", "finished", "origin_speed", "speed", "time", "unused_s",
    )  # fmt: skip

    def __init__(self, ends: Ends, limits: PathLimits, assumed_speed: float = 0.0) -> None:
        self._ends, self._destination = ends, ends.destination
        self._limits = limits
        self._rest: tuple[Vector, float] | None = None
        self.time = self.unused_s = 0.0
        self.finished = ends.origin == ends.destination
        self.arriving = _NOWHERE if self.finished else ends.arriving
        self.origin_speed = self.destination_speed = self.speed = 0.0
        self._place: _Place | None = None
        if self.finished:
            return
        self._coefficients = hermite(ends)
        self._place = _Place(self._coefficients, 0.0, limits)
        self.destination_speed = assumed_speed
        self.origin_speed = self._next_speed(self._place, 0.0, _FOREVER_S, 0.0)
        self.destination_speed = 0.0
        if any(ends.arriving):
            self.destination_speed = _Place(self._coefficients, 1.0, limits).speed_max

    def change_speed(self, limits: PathLimits) -> None:
        """Fly the rest of the leg with other limits (SplineCurve::set_speed_accel)."""
        self._limits = limits

    def limit_destination_speed(self, speed: float) -> None:
        """End not faster than ``speed`` (SplineCurve::set_destination_speed_max)."""
        self.destination_speed = min(self.destination_speed, speed)

    def _next_speed(self, place: _Place, speed: float, dt: float, ahead: float) -> float:
        """Speed after a step from ``speed``: towards what curve and limits allow ``ahead`` m after a place.

        The destination's speed must still be reached over the straight distance to it.
        """
        n, e, u = place.position
        dn, de, du = self._destination
        distance = max(0.0, hypot(dn - n, de - e, du - u) - ahead)
        braking = sqrt(2.0 * place.accel * distance + self.destination_speed**2)
        return clamp(min(place.speed_max, braking), speed - place.accel * dt, speed + place.accel * dt)

    def _time_after(self, place: _Place, distance: float) -> float:
        """Time of the curve a distance on; in small steps, as on board, where that is much of the curve.

        A tangent of centimetres, as before a way straight back, says little of the rate further on.
        """
        step = place.time_for(distance)
        if step < _LONG_STEP:
            return self.time + step
        time, part = self.time, distance / _SMALL_STEPS
        for _ in range(_SMALL_STEPS):
            time += _Place(self._coefficients, min(time, 1.0), self._limits).time_for(part)
        return time

    def _rest_on(self, place: _Place, dt: float) -> Vector:
        """Velocity at the end ``place``; its speed falls on, for the next leg to start with."""
        if self._rest is None:
            stops = not any(self._ends.arriving)
            self._rest = motion_at_rest(self._ends, self._limits) if stops else (_NOWHERE, _REST_M_S)
        (n, e, u), rest = self._rest
        accel = _ALONG_SHARE * self._limits.accel_along((n, e, u)) or place.accel
        self.speed = speed = max(self.speed - accel * dt, rest)
        return n * speed, e * speed, u * speed

    def advance(self, dt: float) -> tuple[Vector, Vector]:
        """Target position and velocity ``dt`` seconds on.

        Source: SplineCurve::advance_target_along_track.
        """
        place, speed = self._place, self.speed
        if place is None:
            self.speed = 0.0
            return self._destination, _NOWHERE
        if self.finished:
            return self._destination, self._rest_on(place, dt)
        soon = self._next_speed(place, speed, dt, speed * dt)
        late = _BRAKES_LATE_S if soon < speed else _STARTS_LATE_S
        distance = 0.5 * (speed + soon) * dt + (speed - soon) * late
        self.time = self._time_after(place, distance)
        if self.time >= 1.0:
            self.unused_s = (self.time - 1.0) * place.rate / speed if speed > 0 else 0.0
            self.time = 1.0
            self.finished = True
        self._place = place = _Place(self._coefficients, self.time, self._limits)
        self.speed = speed = self._next_speed(place, speed, dt, 0.0)
        n, e, u = place.unit if place.rate > 0 or not self.finished else _NOWHERE
        return place.position, (n * speed, e * speed, u * speed)

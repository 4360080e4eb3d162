"""Waypoint navigation: which leg the target is on, how legs join, and how it waits for the copter.

Source: AC_WPNav/AC_WPNav.cpp (4.1 to 4.7). A waypoint is "fast" when the next one is known while
it is flown to: then a straight leg may begin before the one before has ended, and the corner is
cut. The target's clock slows down when the copter falls behind it. Metres north, east, up of home.
"""

from __future__ import annotations

from math import erf, exp, hypot, pi, sqrt

from flight_replay.simulator.airframe import Airframe
from flight_replay.simulator.control import clamp
from flight_replay.simulator.limits import MIN_SPEED_M_S, Limits
from flight_replay.simulator.position_control import PositionControl
from flight_replay.simulator.scurve import PathLimits, SCurve, Vector
from flight_replay.simulator.spline import Spline

_NOWHERE = (0.0, 0.0, 0.0)
_SQRT_HALF, _BELL = sqrt(0.5), 1.0 / sqrt(2.0 * pi)
# AC_WPNav::advance_wp_target_along_track: speed that the target may have beyond the copter's.
_AHEAD_SHARE = 0.05
# Noise of the speed that a position estimate shows at rest. It decides whether the target's clock
# starts fast or slow, by 0.2 s on a leg from rest; the model takes the mean.
_NOISE_M_S = 0.005
_NOISE_MATTERS = 0.02
# The target of a spline never quite rests: its 32-bit curve ends some 0.01 mm off the destination.
# A straight leg from there is planned from that speed, which makes it slower than one from rest.
_SPLINE_REST_M_S = 0.002


def _mean_clamped(mean: float, deviation: float) -> float:
    """Mean of a noisy value that is kept within 0 and 1."""
    if deviation < _NOISE_MATTERS:
        return clamp(mean, 0.0, 1.0)
    low, high = mean / deviation, (mean - 1.0) / deviation
    above_low, above_high = 0.5 * (1.0 + erf(low * _SQRT_HALF)), 0.5 * (1.0 + erf(high * _SQRT_HALF))
    bell = exp(-0.5 * low * low) - exp(-0.5 * high * high)
    return mean * (above_low - above_high) + above_high + deviation * bell * _BELL


def _minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


class WaypointNavigation:
    """The target on its way through waypoints; ``advance`` moves it and flies the airframe after it."""

    def __init__(self, limits: Limits, body: Airframe, control: PositionControl) -> None:
        self._limits, self._body, self._control = limits, body, control
        self._dt = body.dt
        self._corner_accel = limits.corner_accel_m_s2
        self.start()

    def start(self, speed_m_s: float = 0.0, at: Vector | None = None) -> None:
        """Begin at rest at the stopping point, or at a given place (wp_and_spline_init)."""
        limits, control = self._limits, self._control
        self._speed = max(speed_m_s if speed_m_s > 0 else limits.wp_speed_m_s, MIN_SPEED_M_S)
        control.set_speeds(self._speed, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)
        control.limit_correction()
        stopping_point = control.start_at_stopping_point()
        self._origin = self.destination = at or stopping_point
        self._previous = self._leg = self._next = SCurve()
        self._spline: Spline | None = None
        self._next_spline: Spline | None = None
        self._assumed_speed = 0.0
        self._clock_rate = 1.0
        self._unused_s = 0.0
        self.reached = True
        self.fast = False

    def use_limits(self, limits: Limits) -> None:
        """Go by other parameters from now on."""
        self._limits = limits
        self._corner_accel, self._offset_jerk = limits.corner_accel_m_s2, limits.correction_jerk_m_s3

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
        for leg in (self._spline or self._leg, self._next_spline or self._next):
            leg.change_speed(limits)

    # legs

    def fly_straight(self, destination: Vector) -> None:
        """Fly a straight leg from the last destination (set_wp_destination)."""
        if not self.reached:
            self.start(self._speed)
        after_spline = self._spline is not None
        control = self._control
        self._previous = SCurve() if after_spline else self._leg
        self._origin, self.destination = self.destination, destination
        if self.fast and not after_spline and self._next_spline is None and not self._next.finished:
            self._leg = self._next
        else:
            self._leg = SCurve(_minus(destination, self._origin), self._path_limits)
            if after_spline:
                speed = hypot(control.vn, control.ve, control.vu)
                self._leg.limit_origin_speed(max(speed, _SPLINE_REST_M_S))
        self._spline = None
        self._next = SCurve()
        self.fast = self.reached = False

    def then_straight(self, destination: Vector) -> None:
        """Announce a straight leg after this one (set_wp_destination_next)."""
        self._next = SCurve(_minus(destination, self.destination), self._path_limits)
        if self._spline is not None:
            speed = self._next.limit_origin_speed(self._spline.destination_speed)
            self._spline.limit_destination_speed(speed)
        self._next_spline = None
        self.fast = True

    def fly_spline(self, destination: Vector, arriving: Vector) -> None:
        """Fly a spline leg from the last destination, ending along ``arriving`` (set_spline_destination)."""
        if not self.reached:
            self.start(self._speed)
        leaving = _NOWHERE
        if self.fast:
            leaving = self._spline.arriving if self._spline else _minus(self.destination, self._origin)
        self._origin, self.destination = self.destination, destination
        self._spline = Spline(self._origin, destination, leaving, arriving, self._path_limits)
        self.fast = any(arriving)
        self.reached = False

    def then_spline(self, destination: Vector, arriving: Vector) -> None:
        """Announce a spline leg after this one (set_spline_destination_next)."""
        leaving = self._spline.arriving if self._spline else _minus(self.destination, self._origin)
        self._next_spline = spline = Spline(
            self.destination, destination, leaving, arriving, self._path_limits, self._assumed_speed
        )
        self._assumed_speed = spline.destination_speed
        self.fast = True
        (self._spline or self._leg).limit_destination_speed(spline.origin_speed)

    # motion

    def advance(self) -> None:
        """Fly the airframe one step towards the target, and move the target on (update_wpnav)."""
        control = self._control
        dt = self._dt * self._clock() + self._unused_s
        control.update()
        if self._spline is not None:
            speed = hypot(control.vn, control.ve, control.vu)
            position, velocity = self._spline.advance(dt, speed)
            accel = _NOWHERE
            finished, self._unused_s = self._spline.finished, self._spline.unused_s
        else:
            position, velocity, accel, finished = self._advance_straight(dt)
        control.set_target(position, velocity, accel)
        if finished and not self.reached:
            self.reached = self.fast or self._within_radius()

    def _within_radius(self) -> bool:
        n, e, u = self.destination
        body = self._body
        return hypot(body.n - n, body.e - e, body.u - u) <= self._limits.wp_radius_m

    def _clock(self) -> float:
        """How fast the target's time runs: slower when the copter lags (track_scaler_dt)."""
        control, body = self._control, self._body
        vn, ve, vu = control.vn, control.ve, control.vu
        speed = sqrt(vn * vn + ve * ve + vu * vu)
        wanted = 1.0
        if speed > 0:
            behind = (control.n - body.n) * vn + (control.e - body.e) * ve + (control.u - body.u) * vu
            made_good = body.vn * vn + body.ve * ve + body.vu * vu
            gain = self._limits.position_p
            wanted = _AHEAD_SHARE + (made_good - gain * behind) / (speed * speed)
            wanted = _mean_clamped(wanted, _NOISE_M_S / speed)
        # The C code multiplies the acceleration in cm/s² by 0.01 and divides by the jerk in m/s³.
        smooth_s = self._limits.wp_accel_m_s2 / self._limits.wp_jerk_m_s3
        self._clock_rate += (wanted - self._clock_rate) * self._dt / smooth_s
        return self._clock_rate

    def _advance_straight(self, dt: float) -> tuple[Vector, Vector, Vector, bool]:
        """Target on straight legs: the sum of the leg before, this one and the next (SCurve.cpp)."""
        leg, previous, following = self._leg, self._previous, self._next
        moves = []
        if not previous.finished:
            position, speed, accel = previous.advance(dt)
            moves.append((previous.direction, position - previous.length, speed, accel))
        if not leg.empty:
            self._unused_s = max(0.0, leg.time + dt - leg.end_time) if self.fast else 0.0
            moves.append((leg.direction, *leg.advance(dt)))
        finished = leg.finished
        if following.time > 0:
            moves.append((following.direction, *following.advance(dt)))
            finished = finished or following.time >= leg.end_time - leg.time
            self._unused_s = 0.0
        elif self.fast and self._may_turn():
            # The moment has come within the last step, on average in its middle.
            moves.append((following.direction, *following.advance(0.5 * dt)))
        return *self._sum(moves), finished

    def _sum(self, moves: list[tuple[Vector, float, float, float]]) -> tuple[Vector, Vector, Vector]:
        """Position, velocity and acceleration of motions along several directions."""
        n, e, u = self._origin
        vn = ve = vu = an = ae = au = 0.0
        for (dn, de, du), position, speed, accel in moves:
            n, e, u = n + dn * position, e + de * position, u + du * position
            vn, ve, vu = vn + dn * speed, ve + de * speed, vu + du * speed
            an, ae, au = an + dn * accel, ae + de * accel, au + du * accel
        return (n, e, u), (vn, ve, vu), (an, ae, au)

    def _may_turn(self) -> bool:
        """Whether the next leg may begin: its overlap stays within radius, speed and acceleration.

        Source: SCurve::advance_target_along_track.
        """
        leg, following = self._leg, self._next
        if leg.empty or following.empty or leg.time < leg.turn_out_time - following.turn_in_time:
            return False
        half = 0.5 * (leg.end_time - leg.time)
        if leg.position * 2.0 < leg.length or 2.0 * half >= 0.5 * following.end_time:
            return False
        position, speed, accel = leg.at(leg.time + half)
        position2, speed2, accel2 = following.at(half)
        n, e, u = leg.direction
        n2, e2, u2 = following.direction
        position -= leg.length
        up = u * position + u2 * position2
        return (
            hypot(n * position + n2 * position2, e * position + e2 * position2, up) < self._limits.wp_radius_m
            and hypot(n * speed + n2 * speed2, e * speed + e2 * speed2)
            < min(leg.top_speed, following.top_speed)
            and hypot(n * accel + n2 * accel2, e * accel + e2 * accel2) < self._corner_accel
        )

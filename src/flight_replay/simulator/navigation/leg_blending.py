"""Straight legs in a row: at a fast waypoint the next leg begins before the last one has ended.

Source: SCurve::advance_target_along_track. The target moves by the sum of the legs, which cuts
the corner between them.
"""

from __future__ import annotations

from math import hypot

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.navigation.scurve import SCurve

LegMotion = tuple[Vector, float, float, float]
"""A direction, and position m, speed m/s and acceleration m/s² along it."""


class StraightLegs(SnapshotPart):
    """The leg that is flown, the one before, which may not have ended, and the one after."""

    __slots__ = ("current", "following", "previous", "unused_s")

    def __init__(self) -> None:
        self.previous = self.current = self.following = SCurve()
        self.unused_s = 0.0

    def begin(self, leg: SCurve, *, previous: SCurve) -> None:
        """Fly ``leg`` now; the leg after it is not known yet."""
        self.previous, self.current, self.following = previous, leg, SCurve()

    def advance(
        self, dt: float, origin: Vector, corner: Limits | None
    ) -> tuple[Vector, Vector, Vector, bool]:
        """Move ``dt`` seconds on.

        Args:
            dt: seconds.
            origin: where the current leg begins.
            corner: limits within which the corner to the following leg may be cut; None to stop there.

        Returns:
            Target position, velocity and acceleration, and whether the current leg is done.
        """
        leg, previous, following = self.current, self.previous, self.following
        moves: list[LegMotion] = []
        if not previous.finished:
            position, speed, accel = previous.advance(dt)
            moves.append((previous.direction, position - previous.length, speed, accel))
        self.unused_s = 0.0
        if not leg.empty:
            self.unused_s = max(0.0, leg.time + dt - leg.end_time)
            moves.append((leg.direction, *leg.advance(dt)))
        finished = leg.finished
        if following.time > 0:
            moves.append((following.direction, *following.advance(dt)))
            finished = finished or following.time >= leg.end_time - leg.time
            self.unused_s = 0.0
        elif corner is not None and can_blend(leg, following, corner):
            # The blend begins within the last step, on average in its middle.
            moves.append((following.direction, *following.advance(0.5 * dt)))
        return *_sum(origin, moves), finished


def can_blend(leg: SCurve, following: SCurve, limits: Limits) -> bool:
    """Whether the following leg may begin now: the overlap stays within radius, speed and acceleration."""
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
        hypot(n * position + n2 * position2, e * position + e2 * position2, up) < limits.wp_radius_m
        and hypot(n * speed + n2 * speed2, e * speed + e2 * speed2) < min(leg.top_speed, following.top_speed)
        and hypot(n * accel + n2 * accel2, e * accel + e2 * accel2) < limits.corner_accel_m_s2
    )


def _sum(origin: Vector, moves: list[LegMotion]) -> tuple[Vector, Vector, Vector]:
    """Position, velocity and acceleration of motions along several directions."""
    n, e, u = origin
    vn = ve = vu = an = ae = au = 0.0
    for (dn, de, du), position, speed, accel in moves:
        n, e, u = n + dn * position, e + de * position, u + du * position
        vn, ve, vu = vn + dn * speed, ve + de * speed, vu + du * speed
        an, ae, au = an + dn * accel, ae + de * accel, au + du * accel
    return (n, e, u), (vn, ve, vu), (an, ae, au)

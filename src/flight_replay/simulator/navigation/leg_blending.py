"""Straight legs in a row: at a fast waypoint the next leg begins before the last one has ended.

Source: SCurve::advance_target_along_track. The target moves by the sum of the legs, which cuts
the corner between them. Firmware since 4.6.0-beta6 (ardupilot pull request 29601) begins a corner no sooner
than its first leg brakes, and ends it before its second has its speed; climbs and descents in it keep to
their limits.
"""

from __future__ import annotations

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector, norm
from flight_replay.simulator.navigation.scurve import SCurve
from flight_replay.simulator.navigation.scurve_segments import State

Motion = tuple[Vector, Vector, Vector]
"""Position m, velocity m/s and acceleration m/s²."""
_AT_REST: Motion = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


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
        target: Motion = origin, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if not previous.finished:
            position, speed, accel = previous.advance(dt)
            target = _plus(target, previous.direction, (position - previous.length, speed, accel))
        self.unused_s = 0.0
        if not leg.empty:
            self.unused_s = max(0.0, leg.time + dt - leg.end_time)
            target = _plus(target, leg.direction, leg.advance(dt))
        finished = leg.finished
        if following.time > 0:
            target = _plus(target, following.direction, following.advance(dt))
            finished = finished or following.time >= leg.end_time - leg.time
            self.unused_s = 0.0
        elif corner is not None and can_blend(leg, following, corner):
            # The blend begins within the last step, on average in its middle.
            target = _plus(target, following.direction, following.advance(0.5 * dt))
        # A starred target would become a list on the way.
        return target[0], target[1], target[2], finished


def earliest_blend_s(leg: SCurve, following: SCurve, limits: Limits) -> float:
    """When the following leg may begin at the earliest, seconds from the start of the leg."""
    if limits.late_corners > 0:
        return max(leg.turn_out_time, leg.end_time - following.gain_time)
    return leg.turn_out_time - following.turn_in_time


def can_blend(leg: SCurve, following: SCurve, limits: Limits) -> bool:
    """Whether the following leg may begin now: the overlap stays within radius, speed and acceleration."""
    if leg.empty or following.empty or leg.time < earliest_blend_s(leg, following, limits):
        return False
    half = 0.5 * (leg.end_time - leg.time)
    late = limits.late_corners > 0
    if not late and (leg.position * 2.0 < leg.length or 2.0 * half >= 0.5 * following.end_time):
        return False
    position, speed, accel = leg.at(leg.time + half)
    overlap = _plus(_AT_REST, leg.direction, (position - leg.length, speed, accel))
    (n, e, u), (vn, ve, vu), (an, ae, au) = _plus(overlap, following.direction, following.at(half))
    return (
        norm(n, e, u) < limits.wp_radius_m
        and norm(vn, ve, vu if late else 0.0) < min(leg.top_speed, following.top_speed)
        and norm(an, ae) < limits.corner_accel_m_s2
        and (not late or abs(au) < limits.wp_accel_z_m_s2)
    )


def _plus(motion: Motion, direction: Vector, state: State) -> Motion:
    """A motion with that along a leg added."""
    (n, e, u), (vn, ve, vu), (an, ae, au) = motion
    dn, de, du = direction
    position, speed, accel = state
    return (
        (n + dn * position, e + de * position, u + du * position),
        (vn + dn * speed, ve + de * speed, vu + du * speed),
        (an + dn * accel, ae + de * accel, au + du * accel),
    )

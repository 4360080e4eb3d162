"""Streams of GUIDED targets flown by the flight model alone: targets and limits in, trajectory out.

Metres north, east and up of home, and seconds, in the frame and by the clock of the targets.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.copter import STEP_S, Copter
from flight_replay.simulator.flight.guided import GuidedTarget
from flight_replay.simulator.flight.trajectory import Trajectory

# Times closer than this are the same: steps add up rounding errors.
_SAME_TIME_S = 1e-6
# From a message's arrival to the lean that it asks for: one or two of ArduCopter's loops of 2.5 ms.
_LOOPS_S = 0.004


@dataclass(frozen=True, slots=True, eq=False)
class Targets:
    """Targets of one stream, a row each, north, east, up; a row that is not a number leaves that out.

    As in MAVLink, one axis that is left out leaves out its whole group.
    """

    time_s: Floats
    """When each reaches the vehicle, ascending; shape (n,)."""
    position_m: Floats | None = None
    """Shape (n, 3), as are velocity and acceleration."""
    velocity_m_s: Floats | None = None
    acceleration_m_s2: Floats | None = None
    yaw_rad: Floats | None = None
    """Shape (n,), as is the yaw rate."""
    yaw_rate_rad_s: Floats | None = None

    def rows(self) -> list[GuidedTarget]:
        """The targets one by one."""
        n = len(self.time_s)
        return [
            GuidedTarget(*row)
            for row in zip(
                _vectors(self.position_m, n),
                _vectors(self.velocity_m_s, n),
                _vectors(self.acceleration_m_s2, n),
                _numbers(self.yaw_rad, n),
                _numbers(self.yaw_rate_rad_s, n),
                strict=True,
            )
        ]


def _vectors(column: Floats | None, n: int) -> list[Vector | None]:
    if column is None:
        return [None] * n
    return [(row[0], row[1], row[2]) if all(map(isfinite, row)) else None for row in column.tolist()]


def _numbers(column: Floats | None, n: int) -> list[float | None]:
    if column is None:
        return [None] * n
    return [value if isfinite(value) else None for value in column.tolist()]


def simulate_targets(  # noqa: PLR0913
    targets: Targets,
    limits: Limits,
    *,
    start_m: Vector | None = None,
    velocity_m_s: Vector = (0.0, 0.0, 0.0),
    yaw_rad: float | None = None,
    wind_m_s: Vector = (0.0, 0.0, 0.0),
    home_amsl_m: float = 0.0,
    after_s: float = 0.0,
    step_s: float = STEP_S,
) -> Trajectory:
    """Fly a stream of targets in GUIDED; each holds until the next comes, or GUID_TIMEOUT has passed.

    Args:
        targets: what is sent, and when.
        limits: what the vehicle's parameters allow.
        start_m: position at the first target's time; the first position that is sent, if None.
        velocity_m_s: velocity at that time.
        yaw_rad: heading at that time; the first that is sent, or north, if None.
        wind_m_s: velocity of the air.
        home_amsl_m: home above mean sea level, for the density of the air.
        after_s: how long to fly on after the last target.
        step_s: duration of a step.

    Returns:
        The motion at every step, from the first target's time to ``after_s`` after the last; ``auto_s``
        is that span.
    """
    rows = targets.rows()
    copter = Copter(
        limits,
        position_m=_first_position_m(rows) if start_m is None else start_m,
        velocity_m_s=velocity_m_s,
        yaw_rad=_first_yaw_rad(rows) if yaw_rad is None else yaw_rad,
        wind_m_s=wind_m_s,
        home_amsl_m=home_amsl_m,
        step_s=step_s,
    )
    return _fly(copter, targets.time_s.tolist(), rows, after_s)


def _fly(copter: Copter, times: list[float], rows: list[GuidedTarget], after_s: float) -> Trajectory:
    """Give the copter each target at its time."""
    begin, end = times[0], times[-1] + after_s
    motion, turns = [copter.motion], [(copter.yaw_rad, copter.course_rad)]
    sent, half_step_s = 0, 0.5 * copter.step_s
    while (now := begin + copter.time_s) < end - _SAME_TIME_S:
        # A target comes into effect at the nearest step.
        while sent < len(rows) and times[sent] + _LOOPS_S <= now + half_step_s:
            copter.follow(rows[sent], now - times[sent] - _LOOPS_S)
            sent += 1
        copter.step()
        motion.append(copter.motion)
        turns.append((copter.yaw_rad, copter.course_rad))
    time_s, north, east, up, vn, ve, vu = np.array(motion).T
    heading, course = np.degrees(turns).T % 360.0
    return Trajectory(begin + time_s, north, east, up, vn, ve, vu, heading, course, {}, (begin, end))


def _first_position_m(rows: list[GuidedTarget]) -> Vector:
    return next((row.position_m for row in rows if row.position_m is not None), (0.0, 0.0, 0.0))


def _first_yaw_rad(rows: list[GuidedTarget]) -> float:
    return next((row.yaw_rad for row in rows if row.yaw_rad is not None), 0.0)

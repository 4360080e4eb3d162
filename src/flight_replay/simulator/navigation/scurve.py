"""A straight leg as ArduCopter flies it: 23 segments of limited snap, jerk, acceleration and speed.

Source: AP_Math/SCurve.cpp (4.1 to 4.7). A leg is an initial state, seven segments that gain
speed, seven that change it, one at constant speed and seven that lose it. Gaining and losing are
each confined to half of the leg, which is why short legs are slow. Lengths m, times s.
"""

from __future__ import annotations

from typing import Final

from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector, norm
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.scurve_ramp import Kinematics, ramp
from flight_replay.simulator.navigation.scurve_segments import (
    ACCEL_END,
    ACCEL_MAX,
    CHANGE_END,
    CRUISE,
    END,
    START,
    Segment,
    State,
    cruising,
    empty_segment,
    from_speed,
    lack_ramp,
    ramp_segments,
    state_within,
)
from flight_replay.simulator.navigation.scurve_speed_change import with_top_speed

# Of 32-bit numbers: a stop counts as reached when less than this share of the leg is left. A leg ends so
# slowly that this is 0.1 s before its end time.
_RESOLUTION: Final = 1.5e-7
_NO_LIMITS: Final = Kinematics(0.0, 0.0, 0.0)


class SCurve(SnapshotPart):
    """Motion along one straight leg, from rest to rest unless told otherwise; empty without length.

    ``has_error`` says whether ArduPilot reports an internal error on it: it found no ramp where there is one,
    and does not arm again before a reboot.
    """

    __slots__ = (
        "_ends",
        "_limits",
        "_reached_m",
        "_segments",
        "direction",
        "has_error",
        "length",
        "position",
        "time",
        "top_speed",
    )  # fmt: skip

    def __init__(self, track: Vector = (0.0, 0.0, 0.0), limits: PathLimits | None = None) -> None:
        self.time = self.position = self.top_speed = 0.0
        self.has_error = False
        self._segments: list[Segment] = []
        self._ends: list[float] = []
        self.length = length = norm(*track) if limits else 0.0
        self._reached_m = length * (1.0 - _RESOLUTION)
        self.direction, self._limits = (0.0, 0.0, 0.0), _NO_LIMITS
        if limits is None or length == 0:
            return
        self.direction = (track[0] / length, track[1] / length, track[2] / length)
        self._limits = Kinematics(limits.snap_m_s4, limits.jerk_m_s3, limits.accel_along(track))
        self.top_speed = limits.speed_along(track)
        self._set_segments(from_speed(self._limits, 0.0, self.top_speed, length))

    def _set_segments(self, segments: list[Segment]) -> None:
        self._segments = segments
        self.has_error = self.has_error or lack_ramp(segments)
        self._ends = [segment[0] for segment in segments]

    @property
    def empty(self) -> bool:
        """Whether the leg has no length."""
        return not self._segments

    # planning

    def limit_origin_speed(self, speed: float) -> float:
        """Start at ``speed`` if the leg allows; returns the speed at the origin (set_origin_speed_max)."""
        if self.empty:
            return 0.0
        if speed == self._segments[START][2]:
            return speed
        top_speed = self._segments[ACCEL_END][2]
        speed = min(speed, top_speed)
        self._set_segments(from_speed(self._limits, speed, top_speed, self.length))
        return speed

    def limit_destination_speed(self, speed: float) -> None:
        """End at ``speed`` if the leg allows (SCurve::set_destination_speed_max)."""
        if self.empty or speed == self._segments[END][2]:
            return
        top_speed = self._segments[CRUISE][2]
        level = empty_segment(self._segments[CHANGE_END], accelerated=True)
        shape = ramp(self._limits, min(speed, top_speed), top_speed, 0.5 * self.length)
        loss = ramp_segments(level, shape, gain=False)
        self._set_segments(cruising([*self._segments[:CRUISE], level, *loss], self.length))

    def change_speed(self, limits: PathLimits) -> None:
        """Plan the rest of the leg for another top speed (SCurve::set_speed_max)."""
        if self.empty:
            return
        speed = limits.speed_along(self.direction)
        if speed in (self.top_speed, 0.0):
            return
        self.top_speed = speed
        if self.time >= self._segments[CRUISE][0]:
            return
        if self.time > 0:
            position, now, accel = self.at(self.time)
            here: Segment = (self.time, accel, now, position, 0.0, 0.0, 0.0)
            segments, lacks_change = with_top_speed(self._limits, here, self._segments, speed)
            self.has_error = self.has_error or lacks_change
            self._set_segments(segments)
            return
        # Where the braking takes more than half of the leg, this ends beyond its destination.
        start_speed, end_speed, end_m = (
            self._segments[START][2],
            self._segments[END][2],
            self._segments[END][3],
        )
        self._set_segments(from_speed(self._limits, 0.0, speed, end_m))
        self.limit_origin_speed(min(speed, start_speed))
        self.limit_destination_speed(min(speed, end_speed))

    # motion

    def at(self, time: float) -> State:
        """Position, speed and acceleration along the leg at a time."""
        segments = self._segments
        i = _ended_at(self._ends, time)
        if i == 0:
            return _extrapolated(segments[0], time)
        if i > END:
            return _extrapolated(segments[END], time)
        before = segments[i - 1]
        position, speed, accel = state_within(before, segments[i], time - before[0])
        return (position if position > 0 else 0.0), speed, accel

    def advance(self, dt: float) -> State:
        """Move ``dt`` seconds on, to the end at most; returns the state there."""
        self.time = min(self.time + dt, self._ends[END])
        state = self.at(self.time)
        self.position = state[0]
        return state

    @property
    def end_time(self) -> float:
        """Duration of the leg."""
        return self._ends[END] if self._ends else 0.0

    @property
    def turn_in_time(self) -> float:
        """When the full acceleration ends."""
        return self._ends[ACCEL_MAX] if self._ends else 0.0

    @property
    def gain_time(self) -> float:
        """When the speed is gained."""
        return self._ends[ACCEL_END] if self._ends else 0.0

    @property
    def turn_out_time(self) -> float:
        """When braking begins."""
        return self._ends[CRUISE] if self._ends else 0.0

    @property
    def finished(self) -> bool:
        """Whether the end time or the end of the leg is reached."""
        return not self._ends or self.time >= self._ends[END] or self.position >= self._reached_m


def _ended_at(ends: list[float], time: float) -> int:
    """How many segments have ended at a time: ``bisect_right``, which is not compiled."""
    low, high = 0, len(ends)
    while low < high:
        middle = (low + high) >> 1
        if time < ends[middle]:
            high = middle
        else:
            low = middle + 1
    return low


def _extrapolated(segment: Segment, time: float) -> State:
    """Extrapolated from the end of a segment with its speed and acceleration."""
    accel, speed, position = segment[1], segment[2], segment[3]
    s = time - segment[0]
    return max(0.0, position + s * (speed + 0.5 * s * accel)), speed + s * accel, accel

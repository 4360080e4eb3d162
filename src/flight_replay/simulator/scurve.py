"""A straight leg as ArduCopter flies it: 23 segments of limited snap, jerk, acceleration and speed.

Source: AP_Math/SCurve.cpp (4.1 to 4.7). A leg is an initial state, seven segments that gain
speed, seven that change it, one at constant speed and seven that lose it. Gaining and losing are
each confined to half of the leg, which is why short legs are slow. Lengths m, times s.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from math import hypot, pi

from flight_replay.simulator.control import kinematic_limit
from flight_replay.simulator.scurve_ramp import Ramp, ramp
from flight_replay.simulator.scurve_segments import (
    SEGMENTS_IN_RAMP,
    Segment,
    State,
    ramp_segments,
    shifted,
    state_within,
    still,
)

Vector = tuple[float, float, float]

# Indices of the segments that end the parts of a leg.
_START, _ACCEL_MAX, _ACCEL_END, _CHANGE_END, _CRUISE, _END = 0, 4, 7, 14, 15, 22
# Twelve jerk times must fit into the cruise before its speed is changed (SCurve::set_speed_max).
_CHANGE_JERK_TIMES = 12.0


@dataclass(frozen=True, slots=True)
class PathLimits:
    """Speeds m/s, accelerations m/s², jerk m/s³ and snap m/s⁴ that legs are planned with."""

    speed_m_s: float
    speed_up_m_s: float
    speed_down_m_s: float
    accel_m_s2: float
    accel_z_m_s2: float
    jerk_m_s3: float
    snap_m_s4: float

    def speed_along(self, n: float, e: float, u: float) -> float:
        """Highest speed in a direction."""
        return kinematic_limit(n, e, u, self.speed_m_s, self.speed_up_m_s, self.speed_down_m_s)

    def accel_along(self, n: float, e: float, u: float) -> float:
        """Highest acceleration in a direction."""
        return kinematic_limit(n, e, u, self.accel_m_s2, self.accel_z_m_s2, self.accel_z_m_s2)


class SCurve:
    """Motion along one straight leg, from rest to rest unless told otherwise; empty without length."""

    __slots__ = (
        "_accel", "_ends", "_limits", "_segments", "direction", "length", "position", "time", "top_speed",
    )  # fmt: skip

    def __init__(self, track: Vector = (0.0, 0.0, 0.0), limits: PathLimits | None = None) -> None:
        n, e, u = track
        self.time = 0.0
        self.position = 0.0
        self._segments: list[Segment] = []
        self._ends: list[float] = []
        self.length = hypot(n, e, u) if limits else 0.0
        self.direction = (0.0, 0.0, 0.0)
        if self.length == 0 or limits is None:
            return
        self.direction = (n / self.length, e / self.length, u / self.length)
        self._limits = limits
        self.top_speed = limits.speed_along(n, e, u)
        self._accel = limits.accel_along(n, e, u)
        self._plan_from_rest()

    @property
    def empty(self) -> bool:
        """Whether the leg has no length."""
        return not self._segments

    # planning

    def _ramp(self, speed: float, top_speed: float, length: float) -> Ramp:
        limits = self._limits
        return ramp(limits.snap_m_s4, limits.jerk_m_s3, speed, self._accel, top_speed, length)

    def _plan_from_rest(self) -> None:
        """Rest to rest (SCurve::add_segments)."""
        self._plan_from(0.0, self.top_speed)

    def _plan_from(self, speed: float, top_speed: float) -> None:
        """From ``speed`` to rest (SCurve::set_origin_speed_max)."""
        half = 0.5 * self.length
        first: Segment = (0.0, 0.0, speed, 0.0, 0.0, 0.0, 0.0)
        gain = [first, *ramp_segments(first, self._ramp(speed, top_speed, half), gain=True)]
        # A ramp longer than half the leg starts before the leg does.
        early = min(0.0, half - gain[-1][3])
        if early < 0:
            gain = shifted(gain, early / gain[-1][2], early)
        level = still(gain[-1])
        loss = ramp_segments(level, self._ramp(0.0, level[2], half), gain=False)
        self._segments = gain + [level] * (SEGMENTS_IN_RAMP + 1) + loss
        self._stretch_cruise(self.length)

    def _stretch_cruise(self, length: float) -> None:
        """Let the constant speed last until the leg ends at ``length``."""
        segments = self._segments
        spare = max(0.0, length - segments[_END][3])
        speed = segments[_CRUISE][2]
        if speed > 0:
            segments[_CRUISE:] = shifted(segments[_CRUISE:], spare / speed, spare)
        self._ends = [segment[0] for segment in segments]

    def limit_origin_speed(self, speed: float) -> float:
        """Start at ``speed`` if the leg allows; returns the speed at the origin."""
        if self.empty:
            return 0.0
        if speed == self._segments[_START][2]:
            return speed
        top_speed = self._segments[_ACCEL_END][2]
        speed = min(speed, top_speed)
        self._plan_from(speed, top_speed)
        return speed

    def limit_destination_speed(self, speed: float) -> None:
        """End at ``speed`` if the leg allows (SCurve::set_destination_speed_max)."""
        if self.empty or speed == self._segments[_END][2]:
            return
        top_speed = self._segments[_CRUISE][2]
        self._segments[_CRUISE] = level = still(self._segments[_CHANGE_END], accelerated=True)
        shape = self._ramp(min(speed, top_speed), top_speed, 0.5 * self.length)
        self._segments[_CRUISE + 1 :] = ramp_segments(level, shape, gain=False)
        self._stretch_cruise(self.length)

    def change_speed(self, limits: PathLimits) -> None:
        """Plan the rest of the leg for another top speed (SCurve::set_speed_max)."""
        if self.empty:
            return
        speed = limits.speed_along(*self.direction)
        if speed in (self.top_speed, 0.0):
            return
        self._limits, self.top_speed = limits, speed
        segments = self._segments
        if self.time >= segments[_CRUISE][0]:
            return
        end_speed = min(speed, segments[_END][2])
        if self.time == 0:
            start_speed = min(speed, segments[_START][2])
            self._plan_from_rest()
            self.limit_origin_speed(start_speed)
            self.limit_destination_speed(end_speed)
            return
        length = segments[_END][3]
        self._forget_past()
        self._shorten_acceleration(length)
        self._add_speed_change()
        self._brake_to(end_speed, length)

    def _forget_past(self) -> None:
        """Turn what was flown already into the acceleration part, to make room for a further change."""
        segments, time = self._segments, self.time
        if segments[_ACCEL_END][0] <= time <= segments[_CHANGE_END][0]:
            segments[_START] = still(segments[_ACCEL_END], accelerated=True)
            segments[1 : _ACCEL_END + 1] = segments[_ACCEL_END + 1 : _CHANGE_END + 1]
            segments[_ACCEL_END + 1 : _CHANGE_END + 1] = [still(segments[_ACCEL_END])] * SEGMENTS_IN_RAMP
        elif segments[_CHANGE_END][0] < time <= segments[_CRUISE][0]:
            segments[_START] = still(segments[_CHANGE_END])
            position, speed, _ = self.at(time)
            now: Segment = (time, 0.0, speed, position, 0.0, 0.0, 0.0)
            segments[1 : _CHANGE_END + 1] = [now] * _CHANGE_END

    def _shorten_acceleration(self, length: float) -> None:
        """End a running acceleration sooner, if the new speed is below the one it leads to."""
        segments, time, speed = self._segments, self.time, self.top_speed
        peak_start, peak = segments[_ACCEL_MAX - 1], segments[_ACCEL_MAX]
        if time > peak[0] or peak[0] <= peak_start[0] or peak[1] <= 0 or speed >= segments[_ACCEL_END][2]:
            return
        lowest = segments[_ACCEL_END][2] - peak[1] * (peak[0] - max(time, peak_start[0]))
        target = max(lowest, speed)
        start = segments[_START]
        gain = [start, *ramp_segments(start, self._ramp(start[2], target, 0.5 * length), gain=True)]
        level = still(gain[-1])
        loss = ramp_segments(level, self._ramp(0.0, target, 0.5 * length), gain=False)
        self._segments = gain + [level] * (SEGMENTS_IN_RAMP + 1) + loss
        self._stretch_cruise(length)

    def _add_speed_change(self) -> None:
        """Put a ramp to the new speed into the cruise, where there is room for it."""
        segments, speed = self._segments, self.top_speed
        level = still(segments[_ACCEL_END])
        old, room = level[2], segments[_CRUISE][3] - level[3]
        limits = self._limits
        # ArduPilot's cube root is an integer division, 1/3 = 0, so that its first bound is 1 s.
        wait = _CHANGE_JERK_TIMES * min(1.0, limits.jerk_m_s3 * pi / (2.0 * limits.snap_m_s4))
        segments[_ACCEL_END + 1 : _CHANGE_END + 1] = [level] * SEGMENTS_IN_RAMP
        if speed < old and wait < room / old:
            shape, gain = self._ramp(speed, old, 0.5 * room), False
        elif speed > old and room / wait > old:
            shape, gain = self._ramp(old, min(speed, room / wait), 0.5 * room), True
        else:
            return
        if shape.jerk > 0:
            segments[_ACCEL_END + 1 : _CHANGE_END + 1] = ramp_segments(level, shape, gain=gain)

    def _brake_to(self, end_speed: float, length: float) -> None:
        """Lose speed at the end of the leg again, from the new speed."""
        segments = self._segments
        segments[_CRUISE] = level = still(segments[_CHANGE_END])
        end_speed = min(end_speed, level[2])
        if end_speed < level[2]:
            shape = self._ramp(end_speed, level[2], length - level[3])
            segments[_CRUISE + 1 :] = ramp_segments(level, shape, gain=False)
        else:
            segments[_CRUISE + 1 :] = [level] * SEGMENTS_IN_RAMP
        self._stretch_cruise(length)

    # motion

    def at(self, time: float) -> State:
        """Position, speed and acceleration along the leg at a time."""
        segments = self._segments
        i = bisect_right(self._ends, time)
        if i == 0:
            return _coasting(segments[0], time)
        if i > _END:
            return _coasting(segments[_END], time)
        before = segments[i - 1]
        position, speed, accel = state_within(before, segments[i], time - before[0])
        return (position if position > 0 else 0.0), speed, accel

    def advance(self, dt: float) -> State:
        """Move ``dt`` seconds on, to the end at most; returns the state there."""
        self.time = min(self.time + dt, self._ends[_END])
        state = self.at(self.time)
        self.position = state[0]
        return state

    @property
    def end_time(self) -> float:
        """Duration of the leg."""
        return self._ends[_END] if self._ends else 0.0

    @property
    def end_speed(self) -> float:
        """Speed at the destination."""
        return self._segments[_END][2] if self._segments else 0.0

    @property
    def turn_in_time(self) -> float:
        """When the full acceleration ends."""
        return self._ends[_ACCEL_MAX] if self._ends else 0.0

    @property
    def turn_out_time(self) -> float:
        """When braking begins."""
        return self._ends[_CRUISE] if self._ends else 0.0

    @property
    def finished(self) -> bool:
        """Whether time or length is used up."""
        return self.empty or self.time >= self._ends[_END] or self.position >= self.length


def _coasting(segment: Segment, time: float) -> State:
    """On from the end of a segment with its speed and acceleration."""
    t, accel, speed, position, _, _, _ = segment
    s = time - t
    return max(0.0, position + s * (speed + 0.5 * s * accel)), speed + s * accel, accel

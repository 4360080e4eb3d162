"""The segments that make up a straight leg, and how they are joined.

Each segment has constant jerk, or jerk that grows or falls along half a raised cosine
(SCurve.cpp: CONSTANT_JERK, POSITIVE_JERK, NEGATIVE_JERK). Inside one, s seconds after its start,
with w = 0 for constant jerk and else the signed amplitude:
jerk(s) = j - w cos(b s), where b is pi over the duration.
"""

from __future__ import annotations

from math import cos, pi, sin
from typing import Final

from flight_replay.simulator.navigation.scurve_ramp import Kinematics, Ramp, ramp

Segment = tuple[float, float, float, float, float, float, float]
"""End time s, and acceleration, speed, position there; then j, b and w / b of the segment."""
State = tuple[float, float, float]
"""Position m, speed m/s, acceleration m/s² along the leg."""

GROWING: Final = 1
CONSTANT: Final = 0
FALLING: Final = -1
SEGMENTS_IN_RAMP: Final = 7

START: Final = 0
ACCEL_MAX: Final = 4
ACCEL_END: Final = 7
CHANGE_END: Final = 14
CRUISE: Final = 15
END: Final = 22
"""Indices of the segments that end the parts of a leg."""


def state_within(before: Segment, segment: Segment, s: float) -> State:
    """State ``s`` seconds into ``segment``, which follows ``before``."""
    accel, speed, position = before[1], before[2], before[3]
    jerk, beta, part = segment[4], segment[5], segment[6]
    grown = accel + s * jerk
    faster = speed + s * (accel + 0.5 * s * jerk)
    farther = position + s * (speed + s * (0.5 * accel + s * jerk / 6.0))
    if part:
        angle = beta * s
        swing = part * sin(angle)
        part /= beta
        grown -= swing
        faster += part * (cos(angle) - 1.0)
        farther += swing / (beta * beta) - part * s
    return farther, faster, grown


def empty_segment(at: Segment, *, accelerated: bool = False) -> Segment:
    """A segment of no duration after ``at``."""
    return (at[0], at[1] if accelerated else 0.0, at[2], at[3], 0.0, 0.0, 0.0)


def following(before: Segment, duration: float, jerk: float, kind: int) -> Segment:
    """The segment of ``duration`` s after ``before``; ``jerk`` is its peak, m/s³."""
    if duration <= 0:
        return empty_segment(before, accelerated=True)
    if kind != CONSTANT:
        jerk *= 0.5
    beta = pi / duration
    shape = (jerk, beta, kind * jerk / beta)
    position, speed, accel = state_within(before, (0.0, 0.0, 0.0, 0.0, *shape), duration)
    return (before[0] + duration, accel, speed, position, *shape)


def ramp_segments(before: Segment, shape: Ramp, *, gain: bool) -> list[Segment]:
    """The seven segments after ``before`` in which ``shape`` gains or loses speed; they end unaccelerated."""
    first = shape.jerk if gain else -shape.jerk
    parts = [
        (shape.rise_s, first, GROWING),
        (shape.hold_jerk_s, first, CONSTANT),
        (shape.rise_s, first, FALLING),
        (shape.hold_accel_s, 0.0, CONSTANT),
        (shape.rise_s, -first, GROWING),
        (shape.hold_jerk_s, -first, CONSTANT),
        (shape.rise_s, -first, FALLING),
    ]
    segments = []
    for duration, jerk, kind in parts:
        before = following(before, duration, jerk, kind)
        segments.append(before)
    t, _, speed, position, jerk, beta, part = before
    segments[-1] = (t, 0.0, max(0.0, speed), position, jerk, beta, part)
    return segments


def lack_ramp(segments: list[Segment]) -> bool:
    """Whether a leg's gain or loss of speed lasts, as of a ramp that ArduPilot did not find, without jerk."""
    gain, loss = segments[START + 1], segments[CRUISE + 1]
    return (gain[4] == 0.0 and gain[5] > 0.0) or (loss[4] == 0.0 and loss[5] > 0.0)


def shifted(segments: list[Segment], time_s: float, position_m: float) -> list[Segment]:
    """The same segments, later and farther."""
    return [(t + time_s, a, v, p + position_m, j, b, w) for t, a, v, p, j, b, w in segments]


def from_speed(limits: Kinematics, speed: float, top_speed: float, length: float) -> list[Segment]:
    """A leg from ``speed`` to rest (SCurve::add_segments, SCurve::set_origin_speed_max)."""
    half = 0.5 * length
    first: Segment = (0.0, 0.0, speed, 0.0, 0.0, 0.0, 0.0)
    gain = [first, *ramp_segments(first, ramp(limits, speed, top_speed, half), gain=True)]
    # A ramp longer than half the leg starts before the leg does.
    early = min(0.0, half - gain[-1][3])
    if early < 0:
        gain = shifted(gain, early / gain[-1][2], early)
    return with_stop(limits, gain, length)


def with_stop(limits: Kinematics, gain: list[Segment], length: float) -> list[Segment]:
    """A leg of ``length`` that begins with the segments that gain speed, and ends at rest."""
    level = empty_segment(gain[-1])
    loss = ramp_segments(level, ramp(limits, 0.0, level[2], 0.5 * length), gain=False)
    return cruising(gain + [level] * (SEGMENTS_IN_RAMP + 1) + loss, length)


def cruising(segments: list[Segment], length: float) -> list[Segment]:
    """The same leg, its constant speed lasting until it ends at ``length``."""
    spare = max(0.0, length - segments[END][3])
    speed = segments[CRUISE][2]
    if speed <= 0:
        return segments
    return segments[:CRUISE] + shifted(segments[CRUISE:], spare / speed, spare)

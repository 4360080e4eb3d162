"""The segments that make up a straight leg, and how they are joined.

Each segment has constant jerk, or jerk that grows or falls along half a raised cosine
(SCurve.cpp: CONSTANT_JERK, POSITIVE_JERK, NEGATIVE_JERK). Inside one, s seconds after its start,
with w = 0 for constant jerk and else the signed amplitude:
jerk(s) = j - w cos(b s), where b is pi over the duration.
"""

from __future__ import annotations

from math import cos, pi, sin

from flight_replay.simulator.scurve_ramp import Ramp

Segment = tuple[float, float, float, float, float, float, float]
"""End time s, and acceleration, speed, position there; then j, b and w / b of the segment."""
State = tuple[float, float, float]
"""Position m, speed m/s, acceleration m/s² along the leg."""

GROWING, CONSTANT, FALLING = 1, 0, -1
SEGMENTS_IN_RAMP = 7


def state_within(before: Segment, segment: Segment, s: float) -> State:
    """State ``s`` seconds into ``segment``, which follows ``before``."""
    _, accel, speed, position, _, _, _ = before
    jerk, beta, part = segment[4], segment[5], segment[6]
    grown = accel + s * jerk
    faster = speed + s * (accel + 0.5 * s * jerk)
    farther = position + s * (speed + s * (0.5 * accel + s * jerk / 6.0))
    if part:
        angle = beta * s
        bend = part * sin(angle)
        part /= beta
        grown -= bend
        faster += part * (cos(angle) - 1.0)
        farther += bend / (beta * beta) - part * s
    return farther, faster, grown


def still(at: Segment, *, accelerated: bool = False) -> Segment:
    """A segment of no duration after ``at``."""
    return (at[0], at[1] if accelerated else 0.0, at[2], at[3], 0.0, 0.0, 0.0)


def following(before: Segment, duration: float, jerk: float, kind: int) -> Segment:
    """The segment of ``duration`` s after ``before``; ``jerk`` is its peak, m/s³."""
    if duration <= 0:
        return still(before, accelerated=True)
    if kind != CONSTANT:
        jerk *= 0.5
    beta = pi / duration
    shape = (jerk, beta, kind * jerk / beta)
    position, speed, accel = state_within(before, (0.0, 0.0, 0.0, 0.0, *shape), duration)
    return (before[0] + duration, accel, speed, position, *shape)


def ramp_segments(before: Segment, ramp: Ramp, *, gain: bool) -> list[Segment]:
    """The seven segments after ``before`` in which ``ramp`` gains or loses speed; they end unaccelerated."""
    first = ramp.jerk if gain else -ramp.jerk
    parts = [
        (ramp.rise_s, first, GROWING),
        (ramp.hold_jerk_s, first, CONSTANT),
        (ramp.rise_s, first, FALLING),
        (ramp.hold_accel_s, 0.0, CONSTANT),
        (ramp.rise_s, -first, GROWING),
        (ramp.hold_jerk_s, -first, CONSTANT),
        (ramp.rise_s, -first, FALLING),
    ]
    segments = []
    for duration, jerk, kind in parts:
        before = following(before, duration, jerk, kind)
        segments.append(before)
    t, _, speed, position, *shape = before
    segments[-1] = (t, 0.0, max(0.0, speed), position, shape[0], shape[1], shape[2])
    return segments


def shifted(segments: list[Segment], time_s: float, position_m: float) -> list[Segment]:
    """The same segments, later and farther."""
    return [(t + time_s, a, v, p + position_m, j, b, w) for t, a, v, p, j, b, w in segments]

"""A speed change in the middle of a straight leg, as by DO_CHANGE_SPEED.

Source: SCurve::set_speed_max. What was flown becomes the part that gains speed, a ramp to the
new speed goes into the part between, and the braking at the end is planned again.
"""

from __future__ import annotations

from math import pi
from typing import Final

from flight_replay.simulator.navigation.scurve_ramp import NO_RAMP, Kinematics, is_error, ramp
from flight_replay.simulator.navigation.scurve_segments import (
    ACCEL_END,
    ACCEL_MAX,
    CHANGE_END,
    CRUISE,
    END,
    SEGMENTS_IN_RAMP,
    START,
    Segment,
    cruising,
    empty_segment,
    ramp_segments,
    with_stop,
)

# Twelve jerk times must fit into the cruise before its speed is changed.
_JERK_TIMES: Final = 12.0


def with_top_speed(
    limits: Kinematics, now: Segment, segments: list[Segment], speed: float
) -> tuple[list[Segment], bool]:
    """The leg's segments with another top speed from ``now`` on, where the vehicle is on its way.

    And whether ArduPilot reports an internal error, as it did not find the ramp between both speeds.
    """
    length, end_speed = segments[END][3], min(speed, segments[END][2])
    segments = _restarted(segments, now)
    segments = _shorter_gain(limits, segments, now[0], speed)
    segments, lacks_change = _changed_cruise(limits, segments, speed)
    return _braked(limits, segments, end_speed, length), lacks_change


def _restarted(segments: list[Segment], now: Segment) -> list[Segment]:
    """Make what was flown the part that gains speed, so that the speed can change once more."""
    time = now[0]
    if segments[ACCEL_END][0] <= time <= segments[CHANGE_END][0]:
        change = segments[ACCEL_END + 1 : CHANGE_END + 1]
        start = empty_segment(segments[ACCEL_END], accelerated=True)
        return [start, *change, *[empty_segment(change[-1])] * SEGMENTS_IN_RAMP, *segments[CRUISE:]]
    if segments[CHANGE_END][0] < time <= segments[CRUISE][0]:
        return [empty_segment(segments[CHANGE_END]), *[empty_segment(now)] * CHANGE_END, *segments[CRUISE:]]
    return segments


def _shorter_gain(limits: Kinematics, segments: list[Segment], time: float, speed: float) -> list[Segment]:
    """End a running acceleration sooner, if the new speed is below the one it leads to."""
    before, peak = segments[ACCEL_MAX - 1], segments[ACCEL_MAX]
    if time > peak[0] or peak[0] <= before[0] or peak[1] <= 0 or speed >= segments[ACCEL_END][2]:
        return segments
    lowest = segments[ACCEL_END][2] - peak[1] * (peak[0] - max(time, before[0]))
    length, start = segments[END][3], segments[START]
    shape = ramp(limits, start[2], max(lowest, speed), 0.5 * length)
    return with_stop(limits, [start, *ramp_segments(start, shape, gain=True)], length)


def _changed_cruise(limits: Kinematics, segments: list[Segment], speed: float) -> tuple[list[Segment], bool]:
    """Add a ramp to the new speed to the cruise, if there is room for it; and whether none was found."""
    level = empty_segment(segments[ACCEL_END])
    old, room = level[2], segments[CRUISE][3] - level[3]
    # ArduPilot's cube root is an integer division, 1/3 = 0, so that its first bound is 1 s.
    wait = _JERK_TIMES * min(1.0, limits.jerk * pi / (2.0 * limits.snap))
    change, shape = [level] * SEGMENTS_IN_RAMP, NO_RAMP
    if speed < old and wait < room / old:
        shape = ramp(limits, speed, old, 0.5 * room)
        change = ramp_segments(level, shape, gain=False) if shape.jerk > 0 else change
    elif speed > old and room / wait > old:
        shape = ramp(limits, old, min(speed, room / wait), 0.5 * room)
        change = ramp_segments(level, shape, gain=True) if shape.jerk > 0 else change
    return [*segments[: ACCEL_END + 1], *change, *segments[CRUISE:]], is_error(shape)


def _braked(limits: Kinematics, segments: list[Segment], end_speed: float, length: float) -> list[Segment]:
    """Plan the braking at the end of the leg again, from the new speed."""
    level = empty_segment(segments[CHANGE_END])
    end_speed = min(end_speed, level[2])
    loss = [level] * SEGMENTS_IN_RAMP
    if end_speed < level[2]:
        loss = ramp_segments(level, ramp(limits, end_speed, level[2], length - level[3]), gain=False)
    return cruising([*segments[:CRUISE], level, *loss], length)

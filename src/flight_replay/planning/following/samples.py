"""What a reference follows: the recorded fixes on a clock that the vehicle can keep."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.geometry.polyline import segment_lengths_m

_JUMP_M = 5.0
_JUMP_M_S, _JUMP_TIMES, _STEPS_AROUND = 25.0, 3.0, 9
"""A step so fast, and so many times as fast as those around it, was not flown: it is the way between two
flights, or a jump of the estimator."""
_START_AND_STOP_S = 5.0
_LEAST_STEP_S = 1e-3
LONGEST_STEP_S = 2.0
"""Between fixes farther apart in time, the vehicle is taken to have flown straight."""
_GAP_STEP_S = 0.5
_GAP_WEIGHT = 0.02  # Beside the fixes at both ends, which pull the motion through the gap.


@dataclass(frozen=True, slots=True, eq=False)
class Bridge:
    """A way that was not recorded as flown: at ``time_s``, over ``distance_m``, in ``seconds``."""

    time_s: float
    distance_m: float
    seconds: float


def times_with_bridges(
    recorded_s: Floats, places_m: Floats, speed_m_s: float, pace: float = 1.0
) -> tuple[Floats, tuple[Bridge, ...]]:
    """Times (n,) from 0 on to be at the fixes, later behind each jump by the time that the vehicle needs.

    Args:
        recorded_s: when the fixes were recorded (n,): at another pace jumps are the same.
        places_m: of the fixes (n, 2).
        speed_m_s: at which jumps are flown.
        pace: how many times as fast as recorded the rest is followed.
    """
    steps_m = segment_lengths_m(places_m)
    steps_s = np.diff(recorded_s)
    is_jump = jumps(steps_m, steps_s)
    needed_s = steps_m / speed_m_s + _START_AND_STOP_S
    longer_s = np.where(is_jump, np.maximum(needed_s, steps_s / pace), steps_s / pace)
    times = np.concatenate([[0.0], np.cumsum(longer_s)])
    bridges = tuple(
        Bridge(float(times[i]), float(steps_m[i]), float(longer_s[i])) for i in np.flatnonzero(is_jump)
    )
    return times, bridges


def jumps(steps_m: Floats, steps_s: Floats) -> Flags:
    """Which steps from fix to fix (n,), so long and in so much time, were not flown."""
    return np.asarray((steps_m > _JUMP_M) & (steps_m > _jump_speeds_m_s(steps_m, steps_s) * steps_s))


def _jump_speeds_m_s(steps_m: Floats, steps_s: Floats) -> Floats:
    """The speed above which each step (n,) is a jump."""
    if not len(steps_m):
        return steps_m
    around = np.pad(steps_m / np.maximum(steps_s, _LEAST_STEP_S), _STEPS_AROUND // 2)
    usual_m_s = np.median(np.lib.stride_tricks.sliding_window_view(around, _STEPS_AROUND), axis=1)
    return np.maximum(_JUMP_M_S, _JUMP_TIMES * usual_m_s)


def filled(times_s: Floats, values: Floats) -> tuple[Floats, Floats, Floats]:
    """Times (m,), values (m, k) and weights (m,): the fixes, each for its share of time, and gaps filled.

    Args:
        times_s: of the fixes (n,), rising.
        values: at the fixes (n, k), straight between them.
    """
    steps_s = np.minimum(np.diff(times_s), LONGEST_STEP_S)
    weights = (
        (np.append(steps_s[:1], steps_s) + np.append(steps_s, steps_s[-1:])) / 2
        if len(steps_s)
        else np.ones(1)
    )
    between = [
        np.linspace(begin, end, int((end - begin) / _GAP_STEP_S) + 1, endpoint=False)[1:]
        for begin, end in pairwise(times_s)
        if end - begin > LONGEST_STEP_S
    ]
    if not between:
        return times_s, values, weights
    added = np.concatenate(between)
    filling = np.column_stack([np.interp(added, times_s, axis) for axis in values.T])
    return (
        np.concatenate([times_s, added]),
        np.concatenate([values, filling]),
        np.concatenate([weights, np.full(len(added), _GAP_WEIGHT)]),
    )

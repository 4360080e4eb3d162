"""Velocities from positions, for recordings that have none."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.track import Track

_REACH_S = 1.0
"""Velocities are means from so long before a fix to so long behind it, in which noise evens out."""
_LONGEST_STEP_S = 10.0
"""Nothing is known of the motion between positions that are farther apart."""
_ROWS_AT_ONCE = 1 << 14


def with_derived_velocity(track: Track) -> Track:
    """The track with a velocity wherever it had none, the mean over 2 s around each fix.

    To be called with plausible positions only: such a velocity confirms whatever jump it is made from.
    Where only the height is unknown, so is the vertical velocity.
    """
    recorded = track.north_m_s, track.east_m_s, track.up_m_s
    if not track.timed or all(np.isfinite(axis).all() for axis in recorded):
        return track
    north, east, up = filled = [axis.copy() for axis in recorded]
    for first, end in _unbroken(track):
        part = track.select(slice(first, end))
        for rows, around in _pieces(part.time_s):
            near, at_s = part.select(around), part.time_s[rows]
            values = *near.north_east_m(part.frame).T, near.alt_m
            for axis, value in zip(filled, values, strict=True):
                into = axis[first:end][rows]
                np.copyto(into, _slopes(near.time_s, value, at_s), where=~np.isfinite(into))
    return replace(track, north_m_s=north, east_m_s=east, up_m_s=up)


def _unbroken(track: Track) -> list[tuple[int, int]]:
    """First index and end of each part of a track in one boot and without a gap."""
    breaks = (np.diff(track.time_s) > _LONGEST_STEP_S) | (np.diff(track.boot) != 0)
    cuts = [0, *(np.flatnonzero(breaks) + 1).tolist(), len(track)]
    return list(pairwise(cuts))


def _pieces(time_s: Floats) -> Iterator[tuple[slice, slice]]:
    """Times (n,) in pieces that take little memory, and what is within reach of each."""
    for begin in range(0, len(time_s), _ROWS_AT_ONCE):
        rows = slice(begin, min(begin + _ROWS_AT_ONCE, len(time_s)))
        first = int(np.searchsorted(time_s, time_s[begin] - _REACH_S)) - 1
        last = int(np.searchsorted(time_s, time_s[rows.stop - 1] + _REACH_S, "right"))
        # Nobody records more in a second, but a log that is made to take long may.
        yield rows, slice(max(first, begin - _ROWS_AT_ONCE, 0), min(last, rows.stop + _ROWS_AT_ONCE) + 1)


def _slopes(time_s: Floats, values: Floats, at_s: Floats) -> Floats:
    """Mean changes per second (m,) around times (m,) of values (n,) at times (n,); 0 at a single one."""
    before_s, behind_s = np.maximum(at_s - _REACH_S, time_s[0]), np.minimum(at_s + _REACH_S, time_s[-1])
    span_s = behind_s - before_s
    changes = np.interp(behind_s, time_s, values) - np.interp(before_s, time_s, values)
    return np.asarray(changes / np.where(span_s > 0, span_s, 1.0))

"""Velocities from positions, for recordings that have none."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.track import Track

_REACH_S = 1.0
"""Velocities are means from so long before a fix to so long behind it, in which noise evens out."""
_LONGEST_STEP_S = 10.0
"""Nothing is known of the motion between positions that are farther apart."""


def with_derived_velocity(track: Track) -> Track:
    """The track with a velocity wherever it had none, the mean over 2 s around each fix.

    To be called with plausible positions only: such a velocity confirms whatever jump it is made from.
    Where only the height is unknown, so is the vertical velocity.
    """
    recorded = np.column_stack([track.north_m_s, track.east_m_s, track.up_m_s])
    if not track.timed or np.isfinite(recorded).all():
        return track
    derived = np.full((len(track), 3), np.nan)
    for first, end in _unbroken(track):
        part = track.select(slice(first, end))
        derived[first:end, :2] = _slopes(part.time_s, part.north_east_m())
        derived[first:end, 2:] = _slopes(part.time_s, part.alt_m[:, None])
    north, east, up = np.where(np.isfinite(recorded), recorded, derived).T
    return replace(track, north_m_s=north, east_m_s=east, up_m_s=up)


def _unbroken(track: Track) -> list[tuple[int, int]]:
    """First index and end of each part of a track in one boot and without a gap."""
    breaks = (np.diff(track.time_s) > _LONGEST_STEP_S) | (np.diff(track.boot) != 0)
    cuts = [0, *(np.flatnonzero(breaks) + 1).tolist(), len(track)]
    return list(pairwise(cuts))


def _slopes(time_s: Floats, values: Floats) -> Floats:
    """Mean changes per second (n, d) of values (n, d) around times (n,); nothing moves at a single time."""
    before_s = np.maximum(time_s - _REACH_S, time_s[0])
    behind_s = np.minimum(time_s + _REACH_S, time_s[-1])
    span_s = behind_s - before_s
    columns = [np.interp(behind_s, time_s, axis) - np.interp(before_s, time_s, axis) for axis in values.T]
    changes = np.column_stack(columns)
    return np.asarray(changes / np.where(span_s > 0, span_s, 1.0)[:, None])

"""Lines through points: how long their segments are, and where on them a point is nearest.

Metres in a local frame; a line is its points, shape (m, d).
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats

_LEAST_STEP_S = 1e-3


def lengths_m(vector_m: Floats) -> Floats:
    """Lengths (...) of vectors (..., d), d >= 1; numpy's ``norm`` takes three times as long for few axes."""
    columns = [vector_m[..., axis] for axis in range(vector_m.shape[-1])]
    return np.sqrt(_sum([column * column for column in columns]))


def segment_lengths_m(line_m: Floats) -> Floats:
    """Lengths (m - 1,) of the segments of a line (m, d)."""
    return lengths_m(np.diff(line_m, axis=0))


def lengths_along_m(line_m: Floats) -> Floats:
    """Length (m,) of a line (m, d), m >= 1, from its first point up to each of its points."""
    return np.append(0.0, np.cumsum(segment_lengths_m(line_m)))


def speeds_m_s(time_s: Floats, line_m: Floats) -> Floats:
    """Speed (m,) at each point of a line (m, d) that is passed at times (m,): the mean of those around it."""
    if len(line_m) < 2:
        return np.zeros(len(line_m))
    speed = segment_lengths_m(line_m) / np.maximum(np.diff(time_s), _LEAST_STEP_S)
    return np.asarray((np.append(speed[0], speed) + np.append(speed, speed[-1])) / 2)


def nearest_on_segments(point_m: Floats, start_m: Floats, step_m: Floats) -> tuple[Floats, Floats]:
    """Where segments are nearest to points, as the share of the segment (0 to 1), and how far that is.

    The results have the shape that the leading axes of points and segments broadcast to. A segment
    without length is nearest at its start.

    Args:
        point_m: points (..., d).
        start_m: where the segments begin (..., d).
        step_m: from there to where they end, of the same shape.
    """
    # One axis of space after the other, in place: the matching spends most of its time here.
    steps = [step_m[..., axis] for axis in range(step_m.shape[-1])]
    square = _sum([step * step for step in steps])
    per_length = np.where(square > 0, square, 1.0)
    offsets = [point_m[..., axis] - start_m[..., axis] for axis in range(len(steps))]
    share = _sum([offset * (step / per_length) for offset, step in zip(offsets, steps, strict=True)])
    share = np.clip(share, 0.0, 1.0)
    for axis, step in enumerate(steps):
        offsets[axis] -= share * step
        offsets[axis] *= offsets[axis]
    return share, np.sqrt(_sum(offsets))


def _sum(parts: list[Floats]) -> Floats:
    """The sum of arrays of one shape; the first is overwritten."""
    total = parts[0]
    for part in parts[1:]:
        total += part
    return total


def nearest_on_line_m(points_m: Floats, line_m: Floats) -> Floats:
    """The points (n, d) of a line (m, d), m >= 2, that are nearest to points (n, d)."""
    start, step = line_m[:-1], np.diff(line_m, axis=0)
    share, apart = nearest_on_segments(points_m[:, None], start, step)
    nearest, row = apart.argmin(axis=1), np.arange(len(points_m))
    return np.asarray(start[nearest] + share[row, nearest, None] * step[nearest])

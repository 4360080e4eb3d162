"""Dynamic programming: one choice per row, never going back, with the least sum of costs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Bytes, Floats, Indices

_BLOCK = 32
"""Rows whose costs are found together."""


def cheapest_monotone_path(
    costs_of: Callable[[slice, slice], Floats], low: Indices, high: Indices
) -> Indices:
    """The columns (n,), one of each row and never falling, with the smallest sum of costs.

    Args:
        costs_of: gives the costs (rows, columns) of some rows and columns; they may be overwritten.
        low: the first column that each row may have (n,), never falling.
        high: the one behind the last (n,), never falling; each row's columns overlap the next one's.
    """
    marks: list[_Marks] = []
    before, start = np.zeros(1), int(low[0])
    for first in range(0, len(low), _BLOCK):
        rows = slice(first, first + _BLOCK)
        left, right = int(low[first]), int(high[rows][-1])
        costs = costs_of(rows, slice(left, right))
        _forbid(costs, low[rows] - left, high[rows] - left)
        least = np.empty_like(costs)
        before = _continued(before[left - start :], right - left)
        for row, running in zip(costs, least, strict=True):
            np.add(row, before, out=row)
            before = np.minimum.accumulate(row, out=running)
        start = left
        marks.append(_Marks(left, right, np.packbits(least == costs, axis=1)))
    return _backwards(marks, high)


def cheapest_monotone_path_in_band(
    costs_of: Callable[[slice, slice], Floats], cheapest: Indices, low: Indices, high: Indices
) -> Indices:
    """The same, sooner where the bands are so narrow that few rows' cheapest columns (n,) go back.

    Only where they do are the rows searched together, between the columns of those around: seldom is there
    another answer that costs less.
    """
    chosen: Indices = cheapest.copy()
    so_far = np.maximum.accumulate(chosen)
    from_here = np.minimum.accumulate(chosen[::-1])[::-1]
    begins = np.append(0, np.flatnonzero(so_far[:-1] <= from_here[1:]) + 1)
    ends = np.append(begins[1:], len(chosen))
    several = ends - begins > 1
    for begin, end in zip(begins[several].tolist(), ends[several].tolist(), strict=True):
        least = max(so_far[begin - 1], chosen[begin - 1]) if begin else 0
        most = from_here[end] + 1 if end < len(chosen) else high[-1]
        chosen[begin:end] = cheapest_monotone_path(
            _some_rows(costs_of, begin, end),
            np.maximum(low[begin:end], least),
            np.minimum(high[begin:end], most),
        )
    return chosen


def _some_rows(
    costs_of: Callable[[slice, slice], Floats], begin: int, end: int
) -> Callable[[slice, slice], Floats]:
    """The costs of the rows from one up to below another."""
    return lambda rows, columns: costs_of(slice(begin + rows.start, min(begin + rows.stop, end)), columns)


@dataclass(frozen=True, slots=True, eq=False)
class _Marks:
    """Where the running minima of n rows were attained: bits (n, w / 8) of columns ``left`` to ``right``."""

    left: int
    right: int
    bits: Bytes


def _forbid(costs: Floats, low: Indices, high: Indices) -> None:
    """Make all but the columns from ``low`` up to below ``high`` cost too much, in each row."""
    width = costs.shape[1]
    if low[-1] > 0 or high[0] < width:
        column = np.arange(width)
        costs[(column < low[:, None]) | (column >= high[:, None])] = np.inf


def _continued(minima: Floats, width: int) -> Floats:
    """Running minima over more columns: behind the last one they stay what they are."""
    return np.concatenate([minima, np.full(width - len(minima), minima[-1])])


def _backwards(marks: list[_Marks], high: Indices) -> Indices:
    """Walk back through the marks of where each row's running minimum was attained."""
    chosen = np.zeros(len(high), np.intp)
    i, limit = len(high) - 1, int(high[-1])
    for block in reversed(marks):
        limit = min(limit, block.right)
        for attained in np.unpackbits(block.bits, axis=1)[::-1]:
            backwards = attained[: limit - block.left][::-1]
            limit -= int(backwards.argmax())
            chosen[i] = limit - 1
            i -= 1
    return chosen

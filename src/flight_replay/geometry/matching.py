"""Fixes matched to a path going forwards only: dynamic programming, exact to about 1 mm per fix.

Metres in one local frame, over the ground (n, 2) or in space (n, 3).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.monotone_path import cheapest_monotone_path, cheapest_monotone_path_in_band
from flight_replay.geometry.polyline import (
    lengths_along_m,
    lengths_m,
    nearest_on_segments,
    segment_lengths_m,
)
from flight_replay.geometry.scalar.segments import Columns, nearest_in_bands

SHORTEST_PIECE_M, LONGEST_PIECE_M = 0.01, 0.25
"""Within a piece of path the order of fixes is left to a second step, which costs less than its length."""
AFFORDABLE_PAIRS = 8_000_000
"""So many pairs of fix and piece are looked at where that makes pieces shorter."""
MAX_PAIRS_SEARCHED_WHOLE = 20_000_000
"""Up to so many pairs of fix and piece, every pair is looked at."""
COARSE_FIXES, COARSE_PIECES = 1500, 4000
"""Size of the coarse search beyond that; the fine one keeps near what it found."""
QUICK_MAX_PAIRS, QUICK_FIXES, QUICK_PIECES = 1_000_000, 400, 1000
"""The same three where a search asks for one matching after another."""
BAND_M = 40.0
"""How far along the path the fine search strays from the coarse one."""
_NEAR_M = 0.01
"""Fixes nearer to a line than this weigh alike."""
_STILL_M = 1e-3
"""Steps below this change the sum of distances by micrometres: it is flat around its least."""
_MAX_MEDIAN_STEPS = 100
_MIN_MEDIAN_DISTANCE_M = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Matching:
    """Where n fixes lie along a path: distances from it, ground length up to there, and its segment.

    Segment k runs from the path's point k to its point k + 1.
    """

    distance_m: Floats
    along_m: Floats
    segment: Indices


def match_in_order(
    fixes_m: ArrayLike,
    path_m: ArrayLike,
    piece_m: float | None = None,
    *,
    quick: bool = False,
    near_m: tuple[Floats, Floats] | None = None,
) -> Matching:
    """Match fixes (n, d) to the lines through a path's points (m, d), m >= 1, never going back.

    The sum of distances is the smallest there is to about 1 mm per fix. Time and memory grow with n
    times m up to ``MAX_PAIRS_SEARCHED_WHOLE``, beyond that with n plus m: the path is then searched
    within ``BAND_M`` of where a coarse matching lies, and wider wherever the answer touches that bound.

    Args:
        fixes_m: what to match.
        path_m: what to match it to.
        piece_m: the path is searched in pieces of at most this length; the longer, the sooner and
            the less exactly. None: as short as time allows.
        quick: search near a coarse matching wherever that is less work: a tenth of the time for a
            thousand fixes, and seldom another answer.
        near_m: from where to where along the path each fix is likely to be, (n,) each: searched first,
            and further wherever the answer touches that bound. Less work yet.

    Raises:
        ValueError: the path has no point.
    """
    fixes, path = np.asarray(fixes_m, float), np.asarray(path_m, float)
    if not len(path):
        raise ValueError("a path needs at least one point")
    if not len(fixes):
        return Matching(np.zeros(0), np.zeros(0), np.zeros(0, np.intp))
    pieces = _Pieces.of(path, piece_m or _affordable_piece_m(fixes, path))
    chosen = _pieces_near(fixes, pieces, near_m) if near_m else _best_pieces(fixes, pieces, quick=quick)
    along = _along_pieces(fixes, pieces, chosen)
    distance = lengths_m(fixes - pieces.start_m[chosen] - along[:, None] * pieces.unit[chosen])
    return Matching(distance, pieces.begin_m[chosen] + along, pieces.segment[chosen])


def distances_in_order_m(points_m: Floats, line_m: Floats) -> Floats:
    """Distances (n,) of few points (n, 2) from the segments of a line (m, 2) of few, never going back.

    Those with the smallest sum, as of ``match_in_order``, but that points at one segment may be in any order.
    A tenth of its time for a hundred points; without a point or a segment they are 0.
    """
    if len(line_m) < 2 or not len(points_m):
        return np.zeros(len(points_m))
    apart = nearest_on_segments(points_m[:, None], line_m[:-1], np.diff(line_m, axis=0))[1]
    sums, least = apart.copy(), np.empty_like(apart)
    before = np.zeros(apart.shape[1])
    for row, running in zip(sums, least, strict=True):
        np.add(row, before, out=row)
        before = np.minimum.accumulate(row, out=running)
    # The last segment up to each at which the least sum so far was reached.
    reached = np.maximum.accumulate(np.where(sums == least, np.arange(apart.shape[1]), 0), axis=1).tolist()
    chosen, limit = [], -1
    for row in reversed(reached):
        limit = row[limit]
        chosen.append(limit)
    return np.asarray(apart[np.arange(len(apart)), chosen[::-1]])


def _affordable_piece_m(fixes: Floats, path: Floats) -> float:
    """Length of pieces with which ``AFFORDABLE_PAIRS`` of fix and piece are looked at."""
    length_m = float(segment_lengths_m(path).sum())
    return min(max(length_m * len(fixes) / AFFORDABLE_PAIRS, SHORTEST_PIECE_M), LONGEST_PIECE_M)


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """A path cut into w short straight pieces: start and direction (w, d), length, and where each is from.

    ``begin_m`` is the path's length up to a piece, ``segment`` the path's segment that it is part of.
    """

    start_m: Floats
    unit: Floats
    length_m: Floats
    begin_m: Floats
    segment: Indices

    def __len__(self) -> int:
        return len(self.length_m)

    @property
    def step_m(self) -> Floats:
        """From where they begin to where they end (w, d)."""
        return self.length_m[:, None] * self.unit

    @classmethod
    def of(cls, path_m: Floats, piece_m: float) -> _Pieces:
        """Cut the lines through the points into pieces of at most ``piece_m``."""
        if len(path_m) == 1:
            path_m = np.repeat(path_m, 2, axis=0)
        lengths = segment_lengths_m(path_m)
        counts = np.maximum(1, np.ceil(lengths / piece_m)).astype(np.intp)
        segment = np.repeat(np.arange(len(lengths)), counts)
        nth = np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts)
        length = (lengths / counts)[segment]
        unit = (np.diff(path_m, axis=0) / np.where(lengths > 0, lengths, 1.0)[:, None])[segment]
        start = path_m[segment] + (nth * length)[:, None] * unit
        return cls(start, unit, length, lengths_along_m(path_m)[segment] + nth * length, segment)


def _distances(fixes_m: Floats, start_m: Floats, step_m: Floats) -> Callable[[slice, slice], Floats]:
    """What gives the distances (rows, columns) of some of the fixes (n, d) from some of the steps (m, d)."""
    return lambda rows, columns: nearest_on_segments(fixes_m[rows, None], start_m[columns], step_m[columns])[
        1
    ]


def _columns(places_m: Floats) -> Columns:
    """North, east and up of places or steps (n, d)."""
    north, east, *up = places_m.T.tolist()
    return north, east, up[0] if up else [0.0] * len(north)


def _best_pieces(fixes: Floats, pieces: _Pieces, *, quick: bool) -> Indices:
    """The piece of every fix, never falling, that gives the smallest sum of distances."""
    n, m = len(fixes), len(pieces)
    distances = _distances(fixes, pieces.start_m, pieces.step_m)
    if n * m <= (QUICK_MAX_PAIRS if quick else MAX_PAIRS_SEARCHED_WHOLE):
        return cheapest_monotone_path(distances, np.zeros(n, np.intp), np.full(n, m))
    size = (QUICK_FIXES, QUICK_PIECES) if quick else (COARSE_FIXES, COARSE_PIECES)
    low, high = _coarse_band(fixes, pieces, size)
    while True:
        chosen = cheapest_monotone_path(distances, low, high)
        widened = _widened_band(chosen, low, high, m)
        if widened is None:
            return chosen
        low, high = widened


def _pieces_near(fixes: Floats, pieces: _Pieces, near_m: tuple[Floats, Floats]) -> Indices:
    """The same, of the pieces from where to where along the path each fix is likely to be, and around."""
    begin = np.clip(np.searchsorted(pieces.begin_m, near_m[0], side="right") - 1, 0, len(pieces) - 1)
    end = np.searchsorted(pieces.begin_m, near_m[1], side="right")
    low = np.minimum.accumulate(begin[::-1])[::-1]
    high = np.maximum.accumulate(np.maximum(end, begin + 1))
    high = np.maximum(high, np.append(low[1:] + 1, 0))
    step_m = pieces.step_m
    distances = _distances(fixes, pieces.start_m, step_m)
    columns = _columns(fixes), _columns(pieces.start_m), _columns(step_m)
    while True:
        nearest = np.array(nearest_in_bands(*columns, low.tolist(), high.tolist()))
        chosen = cheapest_monotone_path_in_band(distances, nearest, low, high)
        widened = _widened_band(chosen, low, high, len(pieces))
        if widened is None:
            return chosen
        low, high = widened


def _coarse_band(fixes: Floats, pieces: _Pieces, size: tuple[int, int]) -> tuple[Indices, Indices]:
    """Bounds (from, to below) on the piece of every fix, from so many fixes and pieces of a coarse path."""
    n, m = len(fixes), len(pieces)
    anchors = np.unique(np.linspace(0, n - 1, min(n, size[0])).round().astype(np.intp))
    corners = np.unique(np.linspace(0, m - 1, min(m, size[1]) + 1).round().astype(np.intp))
    coarse_m, count = pieces.start_m[corners], len(anchors)
    chosen = cheapest_monotone_path(
        _distances(fixes[anchors], coarse_m[:-1], np.diff(coarse_m, axis=0)),
        np.zeros(count, np.intp),
        np.full(count, len(corners) - 1),
    )
    before = np.searchsorted(anchors, np.arange(n), side="right") - 1
    after = np.searchsorted(anchors, np.arange(n))
    first, last = corners[chosen[before]], corners[chosen[after] + 1]
    low = np.searchsorted(pieces.begin_m, pieces.begin_m[first] - BAND_M)
    high = np.searchsorted(pieces.begin_m, pieces.begin_m[last] + BAND_M, side="right")
    # Fixes far from each other: each band reaches to where the next begins.
    return low, np.maximum(high, np.append(low[1:] + 1, 0))


def _widened_band(chosen: Indices, low: Indices, high: Indices, m: int) -> tuple[Indices, Indices] | None:
    """Wider bounds where the choice touches one that is not the path's end; None where nothing does."""
    touches_low, touches_high = (chosen == low) & (low > 0), (chosen == high - 1) & (high < m)
    if not (touches_low.any() or touches_high.any()):
        return None
    width = high - low
    low = np.where(touches_low, np.maximum(0, low - width), low)
    high = np.where(touches_high, np.minimum(m, high + width), high)
    return np.minimum.accumulate(low[::-1])[::-1], np.maximum.accumulate(high)


def _along_pieces(fixes: Floats, pieces: _Pieces, chosen: Indices) -> Floats:
    """Lengths (n,) from the start of each fix's piece, never falling among fixes on the same piece."""
    relative, unit = fixes - pieces.start_m[chosen], pieces.unit[chosen]
    nearest = (relative * unit).sum(axis=1)
    aside = np.abs(relative[:, 0] * unit[:, 1] - relative[:, 1] * unit[:, 0])
    along = np.clip(nearest, 0.0, pieces.length_m[chosen])
    falls = (np.diff(along) < 0) & (np.diff(chosen) == 0)
    for piece in np.unique(chosen[1:][falls]):
        begin, end = np.searchsorted(chosen, [piece, piece + 1])
        rising = _rising_median(nearest[begin:end], aside[begin:end])
        along[begin:end] = np.clip(rising, 0.0, pieces.length_m[piece])
    return np.asarray(along)


def _rising_median(nearest_m: Floats, aside_m: Floats) -> Floats:
    """Never falling positions (n,) along a line with the smallest sum of distances to n fixes beside it.

    Isotonic regression: adjacent violators are pooled (Barlow et al., 1972), by means that give fixes
    near the line more weight; then each pool moves to the position that suits all of its fixes.

    Args:
        nearest_m: where along the line each fix is nearest (n,).
        aside_m: how far from the line each is (n,).
    """
    weights = 1 / np.maximum(aside_m, _NEAR_M)
    pools: list[tuple[int, float, float]] = []
    for i, (weight, position) in enumerate(zip(weights.tolist(), nearest_m.tolist(), strict=True)):
        begin, total, moment = i, weight, weight * position
        while pools and pools[-1][2] * total > moment * pools[-1][1]:
            begin, more, further = pools.pop()
            total, moment = total + more, moment + further
        pools.append((begin, total, moment))
    begins = [begin for begin, _, _ in pools]
    ends = [*begins[1:], len(nearest_m)]
    medians = [_median_m(nearest_m[b:e], aside_m[b:e]) for b, e in zip(begins, ends, strict=True)]
    return np.repeat(np.maximum.accumulate(medians), np.subtract(ends, begins))


def _median_m(nearest_m: Floats, aside_m: Floats) -> float:
    """The position along a line with the smallest sum of distances to fixes (Weiszfeld's iteration)."""
    if len(nearest_m) == 1:
        return float(nearest_m[0])
    position = float(nearest_m.mean())
    for _ in range(_MAX_MEDIAN_STEPS):
        weight = 1 / np.maximum(np.hypot(nearest_m - position, aside_m), _MIN_MEDIAN_DISTANCE_M)
        moved = float(weight @ nearest_m / weight.sum())
        if abs(moved - position) < _STILL_M:
            break
        position = moved
    return position

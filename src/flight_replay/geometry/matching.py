"""Fixes matched to a path going forwards only: dynamic programming, exact to about 1 mm per fix.

Ground metres in one local frame, shapes (n, 2).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.monotone_path import forwards

SHORTEST_PIECE_M, LONGEST_PIECE_M = 0.01, 0.25
"""Within a piece of path the order of fixes is left to a second step, which costs less than its length."""
CELLS = 8_000_000
"""So many pairs of fix and piece are looked at where that makes pieces shorter."""
WHOLE_CELLS = 20_000_000
"""Up to so many pairs of fix and piece, every pair is looked at."""
COARSE_FIXES, COARSE_PIECES = 1500, 4000
"""Size of the first look at more than that; the second keeps near what it found."""
_NEAR_M = 0.01
"""Fixes nearer to a line than this weigh alike."""
_STILL_M = 1e-3
"""Steps below this change the sum of distances by micrometres: it is flat around its least."""
BAND_M = 40.0
"""How far along the path the second look strays from the first."""


@dataclass(frozen=True, slots=True, eq=False)
class Matching:
    """Where n fixes lie along a path: distances from it, ground length up to there, and the path's piece.

    Piece k ends at the path's point k + 1.
    """

    distance_m: Floats
    along_m: Floats
    piece: Indices


def match_in_order(fixes_m: ArrayLike, path_m: ArrayLike, piece_m: float | None = None) -> Matching:
    """Match fixes (n, 2) to the lines through a path's points (m, 2), m >= 1, never going back.

    The sum of distances is the smallest there is to about 1 mm per fix. Time and memory grow with n
    times m up to ``WHOLE_CELLS``, beyond that with n plus m: the path is then searched within
    ``BAND_M`` of where a coarse matching lies, and wider wherever the answer touches that bound.

    Args:
        fixes_m: what to match.
        path_m: what to match it to.
        piece_m: the path is searched in pieces of at most this length; the longer, the sooner and
            the less exactly. None: as short as time allows.
    """
    fixes, path = np.asarray(fixes_m, float).reshape(-1, 2), np.asarray(path_m, float).reshape(-1, 2)
    if not len(path):
        raise ValueError("a path needs at least one point")
    pieces = _Pieces.of(path, piece_m or _affordable_piece_m(fixes, path))
    if not len(fixes):
        return Matching(np.zeros(0), np.zeros(0), np.zeros(0, np.intp))
    chosen = _choose(fixes, pieces)
    along = _within_pieces(fixes, pieces, chosen)
    reach = pieces.start_m[chosen] + along[:, None] * pieces.unit[chosen]
    distance = np.linalg.norm(fixes - reach, axis=1)
    return Matching(distance, pieces.begin_m[chosen] + along, pieces.parent[chosen])


def _affordable_piece_m(fixes: Floats, path: Floats) -> float:
    """Length of pieces with which ``CELLS`` pairs of fix and piece are looked at."""
    length_m = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    return min(max(length_m * len(fixes) / CELLS, SHORTEST_PIECE_M), LONGEST_PIECE_M)


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """A path cut into short straight pieces, with where each came from."""

    start_m: Floats
    unit: Floats
    length_m: Floats
    begin_m: Floats
    parent: Indices

    def __len__(self) -> int:
        return len(self.length_m)

    @classmethod
    def of(cls, path_m: Floats, piece_m: float) -> _Pieces:
        """Cut the lines through the points into pieces of at most ``piece_m``."""
        if len(path_m) == 1:
            path_m = np.repeat(path_m, 2, axis=0)
        steps = np.diff(path_m, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        counts = np.maximum(1, np.ceil(lengths / piece_m)).astype(np.intp)
        parent = np.repeat(np.arange(len(steps)), counts)
        nth = np.arange(len(parent)) - np.repeat(np.cumsum(counts) - counts, counts)
        length = (lengths / counts)[parent]
        unit = steps[parent] / np.where(lengths > 0, lengths, 1.0)[parent, None]
        start = path_m[parent] + (nth * length)[:, None] * unit
        begin = (np.cumsum(lengths) - lengths)[parent] + nth * length
        return cls(start, unit, length, begin, parent)

    def costs(self, fixes_m: Floats) -> Callable[[slice, slice], Floats]:
        """What gives the distances of some of the fixes (n, 2) from some of the pieces."""
        return lambda rows, where: self.distances(fixes_m[rows], where)

    def distances(self, fixes_m: Floats, where: slice) -> Floats:
        """Distances (n, w) of n fixes from w of the pieces."""
        along_n, along_e = self.unit[where].T
        north = fixes_m[:, :1] - self.start_m[where, 0]
        east = fixes_m[:, 1:] - self.start_m[where, 1]
        along = north * along_n + east * along_e
        np.clip(along, 0.0, self.length_m[where], out=along)
        north -= along * along_n
        east -= along * along_e
        # Several times as fast as np.hypot, whose care for huge numbers is not needed here.
        return np.asarray(np.sqrt(north * north + east * east))


def _choose(fixes: Floats, pieces: _Pieces) -> Indices:
    """The piece of every fix, never falling, that gives the smallest sum of distances."""
    n, m = len(fixes), len(pieces)
    if n * m <= WHOLE_CELLS:
        return forwards(pieces.costs(fixes), np.zeros(n, np.intp), np.full(n, m))
    low, high = _coarse(fixes, pieces)
    while True:
        chosen = forwards(pieces.costs(fixes), low, high)
        widened = _widen(chosen, low, high, m)
        if widened is None:
            return chosen
        low, high = widened


def _coarse(fixes: Floats, pieces: _Pieces) -> tuple[Indices, Indices]:
    """Bounds (from, to below) on the piece of every fix, from some fixes against a coarse path."""
    n, m = len(fixes), len(pieces)
    anchors = np.unique(np.linspace(0, n - 1, min(n, COARSE_FIXES)).round().astype(np.intp))
    corners = np.unique(np.linspace(0, m - 1, min(m, COARSE_PIECES) + 1).round().astype(np.intp))
    line = pieces.start_m[corners]
    steps = np.diff(line, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    unit = steps / np.where(lengths > 0, lengths, 1.0)[:, None]
    rough = _Pieces(line[:-1], unit, lengths, pieces.begin_m[corners[:-1]], corners[:-1])
    count = len(anchors)
    chosen = forwards(rough.costs(fixes[anchors]), np.zeros(count, np.intp), np.full(count, len(rough)))
    before = np.searchsorted(anchors, np.arange(n), side="right") - 1
    after = np.minimum(np.searchsorted(anchors, np.arange(n)), len(anchors) - 1)
    first, last = corners[chosen[before]], corners[chosen[after] + 1]
    low = np.searchsorted(pieces.begin_m, pieces.begin_m[first] - BAND_M)
    high = np.searchsorted(pieces.begin_m, pieces.begin_m[last] + BAND_M, side="right")
    # Fixes far from each other: each band reaches to where the next begins.
    return low, np.maximum(high, np.append(low[1:] + 1, 0))


def _widen(chosen: Indices, low: Indices, high: Indices, m: int) -> tuple[Indices, Indices] | None:
    """Wider bounds where the choice touches one that is not the path's end; None where nothing does."""
    touches_low, touches_high = (chosen == low) & (low > 0), (chosen == high - 1) & (high < m)
    if not (touches_low.any() or touches_high.any()):
        return None
    width = high - low
    low = np.where(touches_low, np.maximum(0, low - width), low)
    high = np.where(touches_high, np.minimum(m, high + width), high)
    return np.minimum.accumulate(low[::-1])[::-1], np.maximum.accumulate(high)


def _within_pieces(fixes: Floats, pieces: _Pieces, chosen: Indices) -> Floats:
    """Lengths (n,) from the start of each fix's piece, never falling among fixes on the same piece."""
    relative = fixes - pieces.start_m[chosen]
    unit = pieces.unit[chosen]
    ideal = (relative * unit).sum(axis=1)
    aside = np.abs(relative[:, 0] * unit[:, 1] - relative[:, 1] * unit[:, 0])
    along = np.clip(ideal, 0.0, pieces.length_m[chosen])
    falls = (np.diff(along) < 0) & (np.diff(chosen) == 0)
    crowded = chosen[1:][falls]
    for piece in crowded[np.diff(crowded, prepend=-1) > 0]:
        begin, end = np.searchsorted(chosen, [piece, piece + 1])
        pooled = _pooled(ideal[begin:end], aside[begin:end])
        along[begin:end] = np.clip(pooled, 0.0, pieces.length_m[piece])
    return np.asarray(along)


def _pooled(ideal_m: Floats, aside_m: Floats) -> Floats:
    """Never falling places along a line with the smallest sum of distances to fixes beside it.

    Adjacent violators are pooled, by means that give fixes near the line more weight; then each pool
    moves to the place that suits all of its fixes.
    """
    weights = 1 / np.maximum(aside_m, _NEAR_M)
    pools: list[tuple[int, float, float]] = []
    for i, (weight, place) in enumerate(zip(weights.tolist(), ideal_m.tolist(), strict=True)):
        begin, total, moment = i, weight, weight * place
        while pools and pools[-1][2] * total > moment * pools[-1][1]:
            begin, more, further = pools.pop()
            total, moment = total + more, moment + further
        pools.append((begin, total, moment))
    begins = [begin for begin, _, _ in pools]
    ends = [*begins[1:], len(ideal_m)]
    places = [_nearest_to_all(ideal_m[b:e], aside_m[b:e]) for b, e in zip(begins, ends, strict=True)]
    counts = np.subtract(ends, begins)
    return np.repeat(np.maximum.accumulate(places), counts)


def _nearest_to_all(ideal_m: Floats, aside_m: Floats) -> float:
    """The place along a line with the smallest sum of distances (Weiszfeld's iteration)."""
    if len(ideal_m) == 1:
        return float(ideal_m[0])
    place = float(ideal_m.mean())
    for _ in range(100):
        weight = 1 / np.maximum(np.hypot(ideal_m - place, aside_m), 1e-4)
        moved = float(weight @ ideal_m / weight.sum())
        if abs(moved - place) < _STILL_M:
            break
        place = moved
    return place

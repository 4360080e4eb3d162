"""Straight routes through recorded fixes, the classic way: what a fit has to beat."""

from __future__ import annotations

import heapq

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import nearest_on_segments
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.reference import LocalTrack

EXACT_M = 0.02
"""A line this near to every fix has no use for more corners."""


def douglas_peucker(points_m: Floats, most: int) -> NDArray[np.intp]:
    """Indices of at most ``most`` of the points (n, d), ends included, after Douglas and Peucker (1973).

    The line is split where a point is farthest from it, worst first, until there are enough.
    """
    last = len(points_m) - 1
    kept = {0, last}
    splits = [_farthest(points_m, 0, last)]
    while len(kept) < most and splits and -splits[0][0] > EXACT_M:
        _, begin, end, middle = heapq.heappop(splits)
        kept.add(middle)
        for part in ((begin, middle), (middle, end)):
            heapq.heappush(splits, _farthest(points_m, *part))
    return np.array(sorted(kept), np.intp)


def _farthest(points_m: Floats, begin: int, end: int) -> tuple[float, int, int, int]:
    """(minus distance, begin, end, index) of the point between two that is farthest from their line."""
    if end - begin < 2:
        return 0.0, begin, end, begin
    chord = points_m[end] - points_m[begin]
    _, apart = nearest_on_segments(points_m[begin + 1 : end], points_m[begin], chord)
    worst = int(np.argmax(apart))
    return -float(apart[worst]), begin, end, begin + 1 + worst


def straight_draft(recording: LocalTrack, kept: NDArray[np.intp]) -> Draft:
    """Straight legs through the kept fixes, after a second to settle at the first."""
    places = np.column_stack([recording.north_east_m, recording.up_m])[kept]
    n = len(kept)
    hold = np.append(1.0, np.zeros(n - 1))
    return Draft(places, np.zeros(n, np.bool_), hold, np.full(n, np.nan))

"""Routes from corner to corner of a recording: those that a fit has to beat, and one to begin with."""

from __future__ import annotations

import heapq
from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.polyline import nearest_on_segments, segment_lengths_m
from flight_replay.planning.fit.draft import Draft, flown_through
from flight_replay.planning.fit.problem import FirstDraft, FitProblem
from flight_replay.planning.fit.reference import Hover, LocalTrack, holds_s, hovers

_NEAR_M = 0.1
"""A line this near to every fix has no use for more corners: fixes are off by centimetres."""
_SHORTEST_PAUSE_S = 2.0
_CORNER_M = 0.3
LONG_M = 10.0
"""A leg as long is straight; shorter ones between the corners of a curve are curved."""


def douglas_peucker(
    points_m: Floats, most: int, near_m: float = _NEAR_M, kept: Iterable[int] = ()
) -> Indices:
    """Indices of at most ``most`` of the points (n, d), after Douglas and Peucker (1973).

    The line is split where a point is farthest from it, worst first, until there are enough, or it is
    nowhere farther than ``near_m``. The ends are kept, and those in ``kept``.
    """
    kept = {0, len(points_m) - 1, *kept}
    splits = [_farthest(points_m, *part) for part in pairwise(sorted(kept))]
    heapq.heapify(splits)
    while len(kept) < most and splits and -splits[0][0] > near_m:
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


def straight_draft(recording: LocalTrack, kept: Indices) -> Draft:
    """Straight legs through the kept fixes, after a second to settle at the first."""
    places, n = recording.north_east_up_m[kept], len(kept)
    hold = np.append(1.0, np.zeros(n - 1))
    return Draft(places, np.zeros(n, np.bool_), hold, np.full(n, np.nan))


def corner_draft(problem: FitProblem, most: int) -> FirstDraft:
    """A route of at most ``most`` places as missions are flown: from corner to corner, with stops at pauses.

    Args:
        problem: its recording has at least two fixes.
        most: at least two.
    """
    nodes = _nodes(problem.recording, hovers(problem.recording, (most - 2) // 2, _SHORTEST_PAUSE_S))
    places_m = np.array([place for place, _ in nodes])
    pauses = {index: pause for index, (_, pause) in enumerate(nodes) if pause is not None}
    kept = douglas_peucker(places_m, most, _CORNER_M, pauses).tolist()
    waits = {place: pauses[node] for place, node in enumerate(kept) if node in pauses}
    places_m = places_m[kept]
    places_m[-1, :2] = problem.recording.north_east_m[-1]
    hold_s = holds_s(len(kept), waits, timed=problem.timed)
    curved = flown_through(hold_s, timed=problem.timed, straight_starts=problem.straight_starts)
    curved[1:] &= segment_lengths_m(places_m) < LONG_M
    return FirstDraft(Draft(places_m, curved, hold_s, np.full(len(kept), np.nan)), waits)


def _nodes(recording: LocalTrack, pauses: list[Hover]) -> list[tuple[Floats, Hover | None]]:
    """Where corners may be: at the first fix, at fixes outside of pauses, and in the middle of pauses."""
    places_m = recording.north_east_up_m
    nodes: list[tuple[Floats, Hover | None]] = [(places_m[0], None)]
    fix = 1
    for pause in pauses:
        nodes += [(place, None) for place in places_m[fix : pause.first]]
        nodes.append((places_m[pause.first : pause.last + 1].mean(axis=0), pause))
        fix = pause.last + 1
    return [*nodes, *((place, None) for place in places_m[fix:])]

"""What a leg between two knots costs: thousands of legs of a handful of fixes each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from flight_replay.geometry.scalar.hermite_leg import (
    Weights,
    between,
    norm_m,
    points_on_leg,
    tangent_factor,
)
from flight_replay.geometry.scalar.segments import Place, least_square_m2, places_of, segments_of

_AROUND_FIXES: Final = 2


@dataclass(slots=True)
class CandidateKnots:
    """Candidates in order: where they are, rows of two or three metres, and how they are flown to.

    Knot k stands for the fixes ``first[k]`` to ``last[k]``; at ``stops`` the vehicle comes to rest, and to
    ``straight`` ones it flies straight.
    """

    rows_m: list[list[float]]
    first: list[int]
    last: list[int]
    stops: list[bool]
    straight: list[bool]


class KnotCost:
    """The cost of legs between knots by the n fixes that they are to follow.

    ``weights`` are those of the points of a curve that is compared with the fixes, ``path_share`` is the
    derivative of the objective by the mean of fourth powers of distances, and ``uneven_share`` that by the
    sum of distances that the vehicle is early or late.
    """

    def __init__(
        self,
        knots: CandidateKnots,
        fixes: tuple[list[list[float]], list[float], list[float]],
        weights: list[Weights],
        path_share: float,
        uneven_share: float,
    ) -> None:
        """With the places (n, d), times and lengths along the recorded line of the fixes."""
        self._place = places_of(knots.rows_m)
        self._first, self._last = knots.first, knots.last
        self._stops, self._straight = knots.stops, knots.straight
        rows, self._time_s, self._along_m = fixes
        self._fixes = places_of(rows)
        self._recorded = segments_of(self._fixes)
        self._weights, self._path_share, self._uneven_share = weights, path_share, uneven_share

    def leg_m(self, before: int, a: int, b: int, after: int) -> float:
        """What the leg from knot a to b costs, with the knots before and after it."""
        begin, end = self._last[a], self._first[b]
        line = self._curve(before, a, b, after)
        cost = self._there_m4(line, begin, end) + self._back_m4(line, begin, end)
        return cost * self._path_share + self._uneven_m(begin, end) * self._uneven_share

    def _there_m4(self, line: list[Place], begin: int, end: int) -> float:
        """What the fixes behind ``begin`` up to ``end`` add to the mean of fourth powers of distances."""
        segments = segments_of(line)
        total = 0.0
        for i in range(begin + 1, end + 1):
            square = least_square_m2(segments, self._fixes[i], 0, len(segments))
            total += square * square
        return total / len(self._fixes)

    def _back_m4(self, line: list[Place], begin: int, end: int) -> float:
        """The same the other way, for the points of the line and the recorded line around the fixes."""
        low = max(0, begin - _AROUND_FIXES)
        high = min(end + _AROUND_FIXES, len(self._recorded))
        total, before = 0.0, 0.0
        for i in range(len(line)):
            square = least_square_m2(self._recorded, line[i], low, high)
            power = square * square
            if i > 0:
                total += (power + before) / 2 * norm_m(between(line[i - 1], line[i]))
            before = power
        return total / max(self._along_m[-1], 1e-6)

    def _curve(self, before: int, a: int, b: int, after: int) -> list[Place]:
        """Points of the leg, see ``mission.path`` for a curve's tangents; a straight leg's are even."""
        origin, destination = self._place[a], self._place[b]
        chord = between(origin, destination)
        if self._straight[b]:
            # The curve with both tangents as long as the chord goes straight at one speed.
            return points_on_leg(origin, destination, chord, chord, self._weights)
        leaving = arriving = (0.0, 0.0, 0.0)
        if not self._stops[a]:
            leaving = between(self._place[before], origin if self._straight[a] else destination)
        if not self._stops[b]:
            arriving = between(destination if self._straight[after] else origin, self._place[after])
        scale = tangent_factor(chord, leaving, arriving)
        leaving = (scale * leaving[0], scale * leaving[1], scale * leaving[2])
        arriving = (scale * arriving[0], scale * arriving[1], scale * arriving[2])
        return points_on_leg(origin, destination, leaving, arriving, self._weights)

    def _uneven_m(self, begin: int, end: int) -> float:
        """How far off flying at one speed from one fix to another is, added up over the fixes between."""
        if end <= begin:
            return 0.0
        begin_s, begin_m = self._time_s[begin], self._along_m[begin]
        speed_m_s = (self._along_m[end] - begin_m) / max(self._time_s[end] - begin_s, 1e-6)
        total = 0.0
        for i in range(begin, end + 1):
            total += abs((self._time_s[i] - begin_s) * speed_m_s - (self._along_m[i] - begin_m))
        return total

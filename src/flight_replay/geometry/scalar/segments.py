"""Straight segments, and how far places are from them: ``polyline.nearest_on_segments`` one by one."""

from __future__ import annotations

from math import sqrt
from typing import Final

Place = tuple[float, float, float]
"""North, east, up, m."""

Columns = tuple[list[float], list[float], list[float]]
"""Places or steps: north, east, up, m."""

_SURELY: Final = 0.001
"""Last bits of lengths and distances come to less of a segment."""


class Segment:
    """Where a segment begins, the step from there to its end, m, and that by its squared length, 1/m."""

    __slots__ = ("per_square", "start", "step")

    # No dataclass: one is made by interpreted code, also where this is compiled.
    def __init__(self, start: Place, end: Place) -> None:
        """From one place to another."""
        self.start = start
        self.step = (end[0] - start[0], end[1] - start[1], end[2] - start[2])
        self.per_square = _per_square(self.step)


def _per_square(step: Place) -> Place:
    """A step by its squared length, 1/m; by 1 where it has no length."""
    n, e, u = step
    square = n * n + e * e + u * u
    if square <= 0.0:
        square = 1.0
    return n / square, e / square, u / square


def places_of(rows: list[list[float]]) -> list[Place]:
    """Rows of two or three metres as places."""
    return [(row[0], row[1], row[2] if len(row) > 2 else 0.0) for row in rows]


def segments_of(line: list[Place]) -> list[Segment]:
    """The m - 1 segments of a line of m places."""
    return [Segment(line[i], line[i + 1]) for i in range(len(line) - 1)]


def _square_m2(place: Place, start: Place, step: Place, per_square: Place) -> float:
    """The square of how far a place is from a segment; one without length is a place itself."""
    n, e, u = place[0] - start[0], place[1] - start[1], place[2] - start[2]
    share = n * per_square[0] + e * per_square[1] + u * per_square[2]
    share = min(max(share, 0.0), 1.0)
    n -= share * step[0]
    e -= share * step[1]
    u -= share * step[2]
    return n * n + e * e + u * u


def least_square_m2(segments: list[Segment], place: Place, begin: int, end: int) -> float:
    """The square of how far a place is from the nearest of the segments ``begin`` to below ``end``."""
    least = float("inf")
    for i in range(begin, end):
        segment = segments[i]
        least = min(least, _square_m2(place, segment.start, segment.step, segment.per_square))
    return least


def nearest_in_bands(
    places: Columns, starts: Columns, steps: Columns, low: list[int], high: list[int]
) -> list[int]:
    """Which of the segments of a line is the nearest to each place, the first of several.

    So far from it as a place is from one of them, no other is within that length of the line: most need not
    be looked at. Columns, as objects would take longer to make than all else.

    Args:
        places: to what.
        starts: where the segments begin, one after the other.
        steps: from there to their ends.
        low: the first that each place may have.
        high: the one behind the last.
    """
    line = _Line(starts, steps)
    chosen: list[int] = []
    guess = 0
    for row in range(len(low)):
        place = (places[0][row], places[1][row], places[2][row])
        end = high[row]
        guess = min(max(guess, low[row]), end - 1)
        least_m, at = line.apart_m(guess, place), low[row]
        while at < end:
            apart_m = line.apart_m(at, place)
            if apart_m < least_m or (apart_m == least_m and at < guess):
                guess, least_m = at, apart_m
            skipped = (apart_m - least_m) / line.longest_m - _SURELY
            at += int(skipped) if skipped > 1.0 else 1
        chosen.append(guess)
    return chosen


class _Line:
    """Segments one after the other; none is longer than ``longest_m``."""

    __slots__ = ("_starts", "_steps", "longest_m")

    def __init__(self, starts: Columns, steps: Columns) -> None:
        """Where they begin, and what leads to where they end."""
        self._starts, self._steps = starts, steps
        longest_m2 = 1e-18
        for i in range(len(steps[0])):
            n, e, u = steps[0][i], steps[1][i], steps[2][i]
            longest_m2 = max(longest_m2, n * n + e * e + u * u)
        self.longest_m = sqrt(longest_m2)

    def apart_m(self, i: int, place: Place) -> float:
        """How far a place is from a segment."""
        start = (self._starts[0][i], self._starts[1][i], self._starts[2][i])
        step = (self._steps[0][i], self._steps[1][i], self._steps[2][i])
        return sqrt(_square_m2(place, start, step, _per_square(step)))

"""Straight segments, and where on them a point is nearest: ``polyline.nearest_on_segments`` one by one."""

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

    __slots__ = (
        *("north_m", "east_m", "up_m", "length_m"),
        *("step_n_m", "step_e_m", "step_u_m", "share_n", "share_e", "share_u"),
    )

    # No dataclass: one is made by interpreted code, also where this is compiled.
    def __init__(self, start: Place, end: Place) -> None:
        """From one place to another."""
        n, e, u = end[0] - start[0], end[1] - start[1], end[2] - start[2]
        square = n * n + e * e + u * u
        self.length_m = sqrt(square)
        if square <= 0.0:
            square = 1.0
        self.north_m, self.east_m, self.up_m = start
        self.step_n_m, self.step_e_m, self.step_u_m = n, e, u
        self.share_n, self.share_e, self.share_u = n / square, e / square, u / square


def places_of(rows: list[list[float]]) -> list[Place]:
    """Rows of two or three metres as places."""
    return [(row[0], row[1], row[2] if len(row) > 2 else 0.0) for row in rows]


def segments_of(line: list[Place]) -> list[Segment]:
    """The m - 1 segments of a line of m places."""
    return [Segment(line[i], line[i + 1]) for i in range(len(line) - 1)]


def nearest(segment: Segment, north_m: float, east_m: float, up_m: float) -> tuple[float, float]:
    """Where a segment is nearest to a place, as its share (0 to 1), and the square of how far that is, m².

    A segment without length is nearest at its start.
    """
    n, e, u = north_m - segment.north_m, east_m - segment.east_m, up_m - segment.up_m
    share = n * segment.share_n + e * segment.share_e + u * segment.share_u
    share = max(share, 0.0)
    share = min(share, 1.0)
    n -= share * segment.step_n_m
    e -= share * segment.step_e_m
    u -= share * segment.step_u_m
    return share, n * n + e * e + u * u


def least_square_m2(segments: list[Segment], place: Place, begin: int, end: int) -> float:
    """The square of how far a place is from the nearest of the segments ``begin`` to below ``end``."""
    north, east, up = place
    least = float("inf")
    for i in range(begin, end):
        square = nearest(segments[i], north, east, up)[1]
        least = min(least, square)
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
        north, east, up = places[0][row], places[1][row], places[2][row]
        end = high[row]
        guess = min(max(guess, low[row]), end - 1)
        least_m, at = line.apart_m(guess, north, east, up), low[row]
        while at < end:
            apart_m = line.apart_m(at, north, east, up)
            if apart_m < least_m or (apart_m == least_m and at < guess):
                guess, least_m = at, apart_m
            skipped = (apart_m - least_m) / line.longest_m - _SURELY
            at += int(skipped) if skipped > 1.0 else 1
        chosen.append(guess)
    return chosen


class _Line:
    """Segments one after the other; none is longer than ``longest_m``."""

    __slots__ = ("_e", "_n", "_squares", "_step_e", "_step_n", "_step_u", "_u", "longest_m")

    def __init__(self, starts: Columns, steps: Columns) -> None:
        """Where they begin, and what leads to where they end."""
        self._n, self._e, self._u = starts
        self._step_n, self._step_e, self._step_u = steps
        self._squares: list[float] = []
        longest_m2 = 1e-18
        for i in range(len(self._step_n)):
            n, e, u = self._step_n[i], self._step_e[i], self._step_u[i]
            square = n * n + e * e + u * u
            longest_m2 = max(longest_m2, square)
            self._squares.append(square if square > 0.0 else 1.0)
        self.longest_m = sqrt(longest_m2)

    def apart_m(self, i: int, north_m: float, east_m: float, up_m: float) -> float:
        """How far a place is from a segment."""
        n, e, u = north_m - self._n[i], east_m - self._e[i], up_m - self._u[i]
        step_n, step_e, step_u, square = self._step_n[i], self._step_e[i], self._step_u[i], self._squares[i]
        share = n * (step_n / square) + e * (step_e / square) + u * (step_u / square)
        share = min(max(share, 0.0), 1.0)
        n -= share * step_n
        e -= share * step_e
        u -= share * step_u
        return sqrt(n * n + e * e + u * u)

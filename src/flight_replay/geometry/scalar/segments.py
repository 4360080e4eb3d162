"""Straight segments, and where on them a point is nearest: ``polyline.nearest_on_segments`` one by one."""

from __future__ import annotations

from math import sqrt

Place = tuple[float, float, float]
"""North, east, up, m."""


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

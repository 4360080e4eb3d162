"""The cubic Hermite curve of a spline leg."""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

from flight_replay.simulator.dynamics.vector import Vector, minus

_LONGEST_TANGENTS = 4.0

Coefficients = tuple[Vector, Vector, Vector, Vector]


class Ends(NamedTuple):
    """Where a curve begins and ends, and its tangents there."""

    origin: Vector
    destination: Vector
    leaving: Vector
    arriving: Vector


def hermite(ends: Ends) -> Coefficients:
    """Coefficients of 1, t, t², t³ of the curve; tangents too long for the chord are scaled down.

    Source: SplineCurve::set_origin_and_destination: together at most four times the chord.
    """
    chord = hypot(*minus(ends.destination, ends.origin))
    tangents = hypot(*ends.leaving) + hypot(*ends.arriving)
    scale = _LONGEST_TANGENTS * chord / tangents if tangents > _LONGEST_TANGENTS * chord else 1.0
    rows = []
    for a, b, leaving, arriving in zip(*ends, strict=True):
        m, k = leaving * scale, arriving * scale
        rows.append((a, m, 3.0 * (b - a) - 2.0 * m - k, 2.0 * (a - b) + m + k))
    n, e, u = rows
    return ((n[0], e[0], u[0]), (n[1], e[1], u[1]), (n[2], e[2], u[2]), (n[3], e[3], u[3]))

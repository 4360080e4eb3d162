"""The cubic Hermite curve of one spline leg: p(t) = c0 + c1 t + c2 t² + c3 t³ for t from 0 to 1.

``geometry.hermite_curve`` is the same curve for many legs at once. The flight model takes one leg
at a time, for which plain numbers are fifteen times as fast as arrays; tests/geometry/test_hermite_curve.py
holds both together.
"""

from __future__ import annotations

from math import hypot
from typing import Final, NamedTuple

from flight_replay.simulator.dynamics.vector import Vector, minus

MAX_TANGENTS_PER_CHORD: Final = 4.0
"""Together the tangents are at most so many chords long (SplineCurve::set_origin_and_destination)."""

Coefficients = tuple[Vector, Vector, Vector, Vector]


class Ends(NamedTuple):
    """Where a curve begins and ends, and its tangents there, which are derivatives by t."""

    origin: Vector
    destination: Vector
    origin_tangent: Vector
    destination_tangent: Vector


def hermite(ends: Ends) -> Coefficients:
    """Coefficients c0 to c3 of the curve; tangents too long for the chord are scaled down.

    They are added up in the order of SplineCurve::update_solution.
    """
    origin, destination = ends.origin, ends.destination
    longest = MAX_TANGENTS_PER_CHORD * _length(minus(destination, origin))
    tangents = _length(ends.origin_tangent) + _length(ends.destination_tangent)
    scale = longest / tangents if tangents > longest else 1.0
    n0, e0, u0 = origin
    n1, e1, u1 = destination
    mn, me, mu = _scaled(ends.origin_tangent, scale)
    kn, ke, ku = _scaled(ends.destination_tangent, scale)
    return (
        origin,
        (mn, me, mu),
        (
            -3.0 * n0 - 2.0 * mn + 3.0 * n1 - kn,
            -3.0 * e0 - 2.0 * me + 3.0 * e1 - ke,
            -3.0 * u0 - 2.0 * mu + 3.0 * u1 - ku,
        ),
        (
            2.0 * n0 + mn - 2.0 * n1 + kn,
            2.0 * e0 + me - 2.0 * e1 + ke,
            2.0 * u0 + mu - 2.0 * u1 + ku,
        ),
    )


def _length(vector: Vector) -> float:
    return hypot(vector[0], vector[1], vector[2])


def _scaled(vector: Vector, scale: float) -> Vector:
    return vector[0] * scale, vector[1] * scale, vector[2] * scale

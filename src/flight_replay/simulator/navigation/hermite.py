"""The cubic Hermite curve of one spline leg: p(t) = c0 + c1 t + c2 t² + c3 t³ for t from 0 to 1.

``geometry.hermite_curve`` is the same curve for many legs at once. The flight model takes one leg
at a time, for which plain numbers are fifteen times as fast as arrays; tests/geometry/test_hermite_curve.py
holds both together.
"""

from __future__ import annotations

from math import hypot
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from flight_replay.simulator.dynamics.vector import Vector, minus

MAX_TANGENTS_PER_CHORD = 4.0
"""Together the tangents are at most so many chords long (SplineCurve::set_origin_and_destination)."""

Axis = TypeVar("Axis", float, NDArray[np.float32])
Coefficients = tuple[Vector, Vector, Vector, Vector]


class Ends(NamedTuple):
    """Where a curve begins and ends, and its tangents there, which are derivatives by t."""

    origin: Vector
    destination: Vector
    origin_tangent: Vector
    destination_tangent: Vector


def hermite(ends: Ends) -> Coefficients:
    """Coefficients c0 to c3 of the curve; tangents too long for the chord are scaled down."""
    longest = MAX_TANGENTS_PER_CHORD * hypot(*minus(ends.destination, ends.origin))
    tangents = hypot(*ends.origin_tangent) + hypot(*ends.destination_tangent)
    scale = longest / tangents if tangents > longest else 1.0
    n, e, u = (axis_coefficients(a, b, m * scale, k * scale) for a, b, m, k in zip(*ends, strict=True))
    return ((n[0], e[0], u[0]), (n[1], e[1], u[1]), (n[2], e[2], u[2]), (n[3], e[3], u[3]))


def axis_coefficients(
    origin: Axis, destination: Axis, origin_tangent: Axis, destination_tangent: Axis
) -> tuple[Axis, Axis, Axis, Axis]:
    """Coefficients c0 to c3 on one axis, added up in the order of SplineCurve::update_solution."""
    return (
        origin,
        origin_tangent,
        -3.0 * origin - 2.0 * origin_tangent + 3.0 * destination - destination_tangent,
        2.0 * origin + origin_tangent - 2.0 * destination + destination_tangent,
    )

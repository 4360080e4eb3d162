"""Vectors in space: north, east, up."""

from __future__ import annotations

from math import sqrt

Vector = tuple[float, float, float]
"""North, east, up."""


def minus(a: Vector, b: Vector) -> Vector:
    """The vector from ``b`` to ``a``."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def norm(n: float, e: float, u: float = 0.0) -> float:
    """Length of a vector; unlike ``math.hypot`` it is compiled with what calls it."""
    return sqrt(n * n + e * e + u * u)

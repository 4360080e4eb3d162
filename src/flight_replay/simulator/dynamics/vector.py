"""Vectors in space: north, east, up."""

from __future__ import annotations

Vector = tuple[float, float, float]
"""North, east, up."""


def minus(a: Vector, b: Vector) -> Vector:
    """The vector from ``b`` to ``a``."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]

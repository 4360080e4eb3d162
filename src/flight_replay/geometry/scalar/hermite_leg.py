"""One leg of the curve of ``geometry.hermite_curve``: how long its tangents may be, and its points."""

from __future__ import annotations

from math import sqrt
from typing import Final

from flight_replay.geometry.scalar.segments import Place

MAX_TANGENTS_PER_CHORD: Final = 4.0
"""Longest sum of both tangents, in lengths of the chord (SPLINE_FACTOR)."""

Weights = tuple[float, float, float, float]
"""What a point is a sum of, as of ``curve_weights``: origin, destination, and the tangents at both."""


def between(tail: Place, head: Place) -> Place:
    """The vector from ``tail`` to ``head``."""
    return head[0] - tail[0], head[1] - tail[1], head[2] - tail[2]


def norm_m(vector: Place) -> float:
    """Length of a vector."""
    return sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2])


def tangent_factor(chord: Place, leaving: Place, arriving: Place) -> float:
    """A factor, at most 1, that makes the tangents at both ends together four chords long at most."""
    longest = MAX_TANGENTS_PER_CHORD * norm_m(chord)
    together = norm_m(leaving) + norm_m(arriving)
    return longest / together if together > longest else 1.0


def points_on_leg(
    origin: Place, destination: Place, leaving: Place, arriving: Place, weights: list[Weights]
) -> list[Place]:
    """The points of a curve with such ends and tangents, one for each of the weights."""
    points: list[Place] = []
    for a, b, c, d in weights:
        points.append(
            (
                a * origin[0] + b * destination[0] + c * leaving[0] + d * arriving[0],
                a * origin[1] + b * destination[1] + c * leaving[1] + d * arriving[1],
                a * origin[2] + b * destination[2] + c * leaving[2] + d * arriving[2],
            )
        )
    return points

"""The cubic Hermite curve that ArduCopter flies on a spline leg, for many points at once.

Source: ``SplineCurve::set_origin_and_destination`` and ``SplineCurve::calc_target_pos_vel`` in
AP_Math/SplineCurve.cpp, 4.0 to 4.7. The curve's parameter t runs from 0 at its origin to 1 at its
destination.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.scalar.hermite_leg import MAX_TANGENTS_PER_CHORD, Weights


def tangent_scale(chord_m: Floats, leaving_m: Floats, arriving_m: Floats) -> Floats:
    """Factors (n,), at most 1, that make the tangents of n curves together four chords long at most.

    Args:
        chord_m: from origin to destination (n, d).
        leaving_m: tangents at the origin (n, d).
        arriving_m: tangents at the destination (n, d).
    """
    longest = MAX_TANGENTS_PER_CHORD * np.linalg.norm(chord_m, axis=1)
    together = np.linalg.norm(leaving_m, axis=1) + np.linalg.norm(arriving_m, axis=1)
    scale: Floats = np.divide(longest, together, out=np.ones_like(longest), where=together > longest)
    return scale


def curve_weights(t: Floats) -> Floats:
    """What points of a curve are sums of: weights (n, 4) at the parameters t (n,).

    In order, those of the curve's origin, of its destination, and of its tangents at both.
    """
    destination = t * t * (3.0 - 2.0 * t)
    leaving, arriving = t * (1.0 - t) ** 2, t * t * (t - 1.0)
    return np.stack([1.0 - destination, destination, leaving, arriving], axis=1)


@lru_cache(maxsize=256)
def weights_of_steps(steps: int) -> list[Weights]:
    """The weights of the ``steps`` + 1 points that equal steps of t lead to, for one leg at a time."""
    rows = curve_weights(np.linspace(0.0, 1.0, steps + 1)).tolist()
    return [(row[0], row[1], row[2], row[3]) for row in rows]


def steps_within(chord_m: Floats, leaving_m: Floats, arriving_m: Floats, tolerance_m: float) -> Indices:
    """Number of equal steps of t (n,) whose straight lines lie within a tolerance of n curves.

    A line over a step h is at most h² / 8 times the largest second derivative away; that of a cubic
    is largest at one of its ends. Arguments as in ``tangent_scale``, tangents scaled.
    """
    at_origin = 6.0 * chord_m - 4.0 * leaving_m - 2.0 * arriving_m
    at_destination = -6.0 * chord_m + 2.0 * leaving_m + 4.0 * arriving_m
    largest = np.maximum(np.linalg.norm(at_origin, axis=1), np.linalg.norm(at_destination, axis=1))
    steps: Indices = np.ceil(np.sqrt(largest / (8.0 * tolerance_m))).astype(np.intp)
    return np.maximum(1, steps)

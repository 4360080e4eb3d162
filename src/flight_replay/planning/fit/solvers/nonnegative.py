"""The smallest value of a convex quadratic function of numbers that are not negative."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats

_MOST_PIVOTS = 100
_PATIENCE = 3
"""So often all that is wrong may be exchanged at once without a gain; then one by one, which ends surely."""
_NOTHING = 1e-12


def smallest_nonnegative(matrix: Floats, force: Floats) -> Floats:
    """The numbers x (p,), none negative, for which x' M x / 2 - f' x is smallest.

    Scipy's ``nnls`` takes one number after the other in, ten times as long. Block principal pivoting takes
    all at once that have the wrong sign, and solves for the rest: a handful of solutions (Portugal, Júdice
    and Vicente, 1994).

    Args:
        matrix: M (p, p), positive definite.
        force: f (p,).
    """
    free = np.zeros(len(force), np.bool_)
    found, slope = np.zeros(len(force)), -force
    fewest, patience = len(force) + 1, _PATIENCE
    for _ in range(_MOST_PIVOTS):
        wrong = np.where(free, found, slope) < -_NOTHING
        count = int(wrong.sum())
        if count == 0:
            break
        if count < fewest:
            fewest, patience = count, _PATIENCE
        elif patience > 0:
            patience -= 1
        else:
            wrong = np.arange(len(force)) == np.flatnonzero(wrong)[-1]
        free ^= wrong
        inside = np.flatnonzero(free)
        found = np.zeros(len(force))
        found[inside] = np.linalg.solve(matrix[np.ix_(inside, inside)], force[inside])
        slope = matrix @ found - force
    return np.maximum(found, 0.0)

"""Symmetric equations whose matrix has all that is not zero near its diagonal."""

from __future__ import annotations

from flight_replay.geometry.arrays import Floats


def solve_banded(matrix: Floats, right: Floats, width: int) -> Floats:
    """The solution (n,) of ``matrix @ solution = right``, by elimination within the band.

    In a fixed order of sums, unlike a library's solver with several threads, and without its cost.

    Args:
        matrix: symmetric and positive definite (n, n).
        right: (n,).
        width: nothing but zeros is farther than so many columns from the diagonal.
    """
    left: Floats = matrix.copy()
    solution: Floats = right.copy()
    count = len(solution)
    for k in range(count):
        below = slice(k + 1, min(k + 1 + width, count))
        factor = left[below, k] / left[k, k]
        left[below, below] -= factor[:, None] * left[k, below]
        solution[below] -= factor * solution[k]
    for k in range(count - 1, -1, -1):
        below = slice(k + 1, min(k + 1 + width, count))
        solution[k] = (solution[k] - (left[k, below] * solution[below]).sum()) / left[k, k]
    return solution

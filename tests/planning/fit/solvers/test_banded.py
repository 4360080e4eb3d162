"""Elimination within the band."""

import numpy as np

from flight_replay.planning.fit.solvers.banded import solve_banded


def test_it_solves_what_a_library_solves() -> None:
    """Random banded matrices, also narrower than the band that is allowed for."""
    rng = np.random.default_rng(1)
    for count in (1, 3, 40):
        matrix = rng.normal(size=(count, count))
        matrix[abs(np.arange(count)[:, None] - np.arange(count)) > 3] = 0.0
        matrix = matrix @ matrix.T + np.eye(count)
        right = rng.normal(size=count)
        assert np.allclose(solve_banded(matrix, right, 7), np.linalg.solve(matrix, right))

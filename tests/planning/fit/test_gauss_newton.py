"""Moving places so that a path meets the fixes."""

import numpy as np

from flight_replay.planning.fit.basis import weights
from flight_replay.planning.fit.gauss_newton import Residuals, gauss_newton_step
from tests.helpers.fit_tracks import draft_of


def test_a_pull_moves_the_path_to_where_it_draws() -> None:
    """Points drawn aside by a metre arrive there, and the ends stay."""
    draft = draft_of([(10.0 * i, 0) for i in range(8)], [i > 0 for i in range(8)], [1.0] + [0.0] * 7)
    leg, part = np.repeat(np.arange(2, 7), 3), np.tile([0.2, 0.5, 0.9], 5)
    off = np.tile([0.0, 1.0], (15, 1))
    residual = Residuals(leg, part, np.tile([1.0, 0.0], (15, 1)), off, np.ones(15))
    moved = gauss_newton_step(draft, [residual], smoothing=1e-4)
    there = weights(moved, leg, part) @ moved.places_m[:, :2]
    assert np.allclose(there[6:9, 1], 1.0, atol=0.05)
    assert np.allclose(moved.places_m[[0, -1]], draft.places_m[[0, -1]])


def test_two_places_cannot_be_pulled() -> None:
    """A route of two places is its ends."""
    draft = draft_of([(0, 0), (10, 0)], [False, False], [1, 0])
    assert gauss_newton_step(draft, [], smoothing=1.0) is draft

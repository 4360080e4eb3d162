"""The weights of places on the points of a planned path."""

import numpy as np

from flight_replay.planning.fit.basis import weights
from tests.helpers.fit_tracks import MIXED


def test_the_weights_draw_the_planned_path() -> None:
    """Every point of a mixed path is the weighted sum of its places, straight legs, curves and halts."""
    path = MIXED.path(0.01)
    for leg in range(1, len(MIXED)):
        points = path.north_east_m[path.seq == leg]
        part = np.arange(1, len(points) + 1) / len(points)
        drawn = weights(MIXED, np.full(len(points), leg), part) @ MIXED.places_m[:, :2]
        assert np.allclose(drawn, points, atol=1e-9)

"""Path errors, position errors, and their statistics."""

import numpy as np
import pytest

from flight_replay.geometry.distances import error_statistics, position_errors_m


def test_distance_in_time_is_at_equal_times() -> None:
    """Each recorded fix stands against the flown position at its time, over the part both have."""
    recorded_s, recorded = [0.0, 1.0, 2.0, 3.0], [[0, 0], [1, 0], [2, 0], [3, 0]]
    apart = position_errors_m(recorded_s, recorded, [-1.0, 0.0, 2.5], [[0, 5], [0, 0], [5, 0]])
    assert apart == pytest.approx([0, 1, 2])
    assert position_errors_m(recorded_s, recorded, [], np.zeros((0, 2))).shape == (0,)


def test_a_spread_has_mean_p95_and_max() -> None:
    """Distances come down to three numbers, and to none when there are none."""
    found = error_statistics(np.arange(101.0))
    assert found is not None
    assert (found.mean, found.p95, found.max) == (50, 95, 100)
    assert error_statistics([]) is None

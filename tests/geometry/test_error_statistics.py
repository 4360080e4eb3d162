"""Statistics of errors."""

import numpy as np
import pytest

from flight_replay.geometry.error_statistics import error_statistics


def test_statistics_are_mean_p95_and_max() -> None:
    """In whatever order the errors come; none when there are none."""
    found = error_statistics(np.random.default_rng(1).permutation(101))
    assert found is not None
    assert (found.mean, found.p95, found.max) == (50, 95, 100)
    small = error_statistics([3.0, 1.0])
    assert small is not None
    assert (small.mean, small.p95, small.max) == pytest.approx((2.0, 2.9, 3.0))
    assert error_statistics([]) is None

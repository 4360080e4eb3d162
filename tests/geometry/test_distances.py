"""Path errors, position errors, and their statistics."""

import numpy as np
import pytest

from flight_replay.geometry.distances import error_statistics, path_errors_m, position_errors_m


def test_path_errors_are_distances_from_the_matched_path() -> None:
    """A path of one point takes every fix; no fixes give no errors."""
    assert path_errors_m([[5, 2], [8, -1]], [[0, 0], [10, 0]]) == pytest.approx([2, 1])
    assert path_errors_m([[3, 4], [0, 1]], [[0, 0]]) == pytest.approx([5, 1])
    assert path_errors_m(np.zeros((0, 2)), [[0, 0]]).shape == (0,)


def test_position_errors_are_distances_at_equal_times() -> None:
    """Each recorded fix stands against the flown position at its time, north and east."""
    recorded = [[0, 0], [1, 4], [2, 8], [3, 0]]
    flown_s, flown = [-1.0, 0.0, 2.5], [[0, 5], [3, 4], [8, 4]]
    errors = position_errors_m([0.0, 1.0, 2.0, 3.0], recorded, flown_s, flown)
    assert errors == pytest.approx([5, 4, np.hypot(5, 4)])


def test_position_errors_cover_what_both_have() -> None:
    """The first and last flown times count too, fixes before and after do not."""
    times, places = [0.0, 1.0, 2.0, 3.0, 4.0], [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0]]
    assert position_errors_m(times, places, [1.0, 3.0], [[1, 1], [3, 2]]) == pytest.approx([1, 1.5, 2])
    assert position_errors_m(times, places, [7.0, 9.0], [[1, 1], [3, 2]]).shape == (0,)
    assert position_errors_m(times, places, [], []).shape == (0,)
    assert position_errors_m([], [], [1.0, 3.0], [[1, 1], [3, 2]]).shape == (0,)


def test_statistics_are_mean_p95_and_max() -> None:
    """In whatever order the errors come; none when there are none."""
    found = error_statistics(np.random.default_rng(1).permutation(101))
    assert found is not None
    assert (found.mean, found.p95, found.max) == (50, 95, 100)
    small = error_statistics([3.0, 1.0])
    assert small is not None
    assert (small.mean, small.p95, small.max) == pytest.approx((2.0, 2.9, 3.0))
    assert error_statistics([]) is None

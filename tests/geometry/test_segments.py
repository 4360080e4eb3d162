"""Segments one by one: the same as many at once."""

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import nearest_on_segments
from flight_replay.geometry.scalar.segments import (
    Columns,
    least_square_m2,
    nearest_in_bands,
    places_of,
    segments_of,
)


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_segments_one_by_one_are_as_near_as_many_at_once(seed: int, axes: int) -> None:
    """Over the ground and in space, also where a segment has no length."""
    random = np.random.default_rng(seed)
    points_m, line_m = random.normal(0, 5, (7, axes)), random.normal(0, 5, (6, axes))
    line_m[3] = line_m[2]
    apart_m = nearest_on_segments(points_m[:, None], line_m[:-1], np.diff(line_m, axis=0))[1]
    segments = segments_of(places_of(line_m.tolist()))
    for k in range(len(segments)):
        alone = [least_square_m2(segments, place, k, k + 1) for place in places_of(points_m.tolist())]
        assert np.sqrt(alone) == pytest.approx(apart_m[:, k], abs=1e-12)
    least = [least_square_m2(segments, place, 1, 4) for place in places_of(points_m.tolist())]
    assert np.sqrt(least) == pytest.approx(apart_m[:, 1:4].min(axis=1), abs=1e-12)


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("spread_m", [0.0, 1.0, 30.0])
@pytest.mark.parametrize("seed", range(5))
def test_the_nearest_of_a_band_is_found_though_most_are_not_looked_at(
    seed: int, spread_m: float, axes: int
) -> None:
    """Of a line with segments of all lengths, some without one."""
    random = np.random.default_rng(seed)
    steps_m = random.normal(0, 1, (300, axes)) * random.choice([0.0, 0.1, 1.0], (300, 1))
    line_m = np.cumsum(steps_m, axis=0)
    points_m = line_m[np.sort(random.integers(0, 299, 80))] + spread_m * random.normal(0, 1, (80, axes))
    low = random.integers(0, 250, 80)
    high = low + random.integers(1, 49, 80)
    apart_m = nearest_on_segments(points_m[:, None], line_m[:-1], np.diff(line_m, axis=0))[1]
    line = _columns(line_m[:-1]), _columns(np.diff(line_m, axis=0))
    found = nearest_in_bands(_columns(points_m), *line, low.tolist(), high.tolist())
    wanted = [a + row[a:b].argmin() for row, a, b in zip(apart_m, low, high, strict=True)]
    apart = apart_m[np.arange(80), found]
    assert apart == pytest.approx(apart_m[np.arange(80), wanted], abs=1e-12)
    assert all(a <= at < b for at, a, b in zip(found, low, high, strict=True))


def _columns(places_m: Floats) -> Columns:
    """North, east and up."""
    up = np.zeros((len(places_m), 3 - places_m.shape[1]))
    north, east, up = np.column_stack([places_m, up]).T.tolist()
    return north, east, up


def test_a_line_of_one_point_has_no_segment() -> None:
    """Nor has one of none, and nothing is infinitely far away."""
    assert segments_of(places_of([[1.0, 2.0]])) == segments_of([]) == []
    assert least_square_m2([], (0.0, 0.0, 0.0), 0, 0) == float("inf")

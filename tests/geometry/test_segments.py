"""Segments one by one: the same as many at once."""

import numpy as np
import pytest

from flight_replay.geometry.polyline import nearest_on_segments
from flight_replay.geometry.scalar.segments import least_square_m2, nearest, places_of, segments_of


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_segments_one_by_one_are_as_near_as_many_at_once(seed: int, axes: int) -> None:
    """Over the ground and in space, also where a segment has no length."""
    random = np.random.default_rng(seed)
    points_m, line_m = random.normal(0, 5, (7, axes)), random.normal(0, 5, (6, axes))
    line_m[3] = line_m[2]
    share, apart_m = nearest_on_segments(points_m[:, None], line_m[:-1], np.diff(line_m, axis=0))
    segments = segments_of(places_of(line_m.tolist()))
    found = [[nearest(segment, *place) for segment in segments] for place in places_of(points_m.tolist())]
    assert np.array(found)[:, :, 0] == pytest.approx(share, abs=1e-12)
    assert np.sqrt(np.array(found)[:, :, 1]) == pytest.approx(apart_m, abs=1e-12)
    least = [least_square_m2(segments, place, 1, 4) for place in places_of(points_m.tolist())]
    assert np.sqrt(least) == pytest.approx(apart_m[:, 1:4].min(axis=1), abs=1e-12)


def test_a_line_of_one_point_has_no_segment() -> None:
    """Nor has one of none, and nothing is infinitely far away."""
    assert segments_of(places_of([[1.0, 2.0]])) == segments_of([]) == []
    assert least_square_m2([], (0.0, 0.0, 0.0), 0, 0) == float("inf")

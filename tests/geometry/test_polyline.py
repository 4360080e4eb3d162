"""Lines through points: lengths along them, and where they are nearest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import (
    lengths_along_m,
    nearest_on_line_m,
    nearest_on_segments,
    segment_lengths_m,
    speeds_m_s,
)

COORDINATES = st.floats(-20, 20, width=32)


def test_lengths_are_those_of_the_segments_and_their_sums() -> None:
    """A line of 3, 0 and 4 m is 7 m long at its last point; one point is a line without length."""
    line = np.array([[0.0, 0, 0], [3, 0, 0], [3, 0, 0], [3, 0, 4]])
    assert segment_lengths_m(line).tolist() == [3, 0, 4]
    assert lengths_along_m(line).tolist() == [0, 3, 3, 7]
    assert lengths_along_m(line[:1]).tolist() == [0]


@pytest.mark.parametrize(
    ("point", "share", "distance"),
    [((5, 3), 0.5, 3), ((-3, 4), 0, 5), ((13, -4), 1, 5), ((2, 0), 0.2, 0)],
    ids=["beside", "before", "behind", "on it"],
)
def test_nearest_beside_before_and_behind(point: tuple[float, float], share: float, distance: float) -> None:
    """Beside a segment its line is nearest, elsewhere one of its ends."""
    found = nearest_on_segments(np.array(point, float), np.zeros(2), np.array([10.0, 0]))
    assert [float(value) for value in found] == pytest.approx([share, distance])


def test_a_segment_without_length_is_a_point() -> None:
    """Its start is nearest, wherever the point is."""
    found = nearest_on_segments(np.array([4.0, 6.0]), np.array([1.0, 2.0]), np.zeros(2))
    assert [float(value) for value in found] == [0, 5]


@settings(max_examples=50)
@given(arrays(float, (5, 1, 3), elements=COORDINATES), arrays(float, (2, 4, 3), elements=COORDINATES))
def test_every_point_with_every_segment(points: Floats, ends: Floats) -> None:
    """Axes in front broadcast: (5, 4) results that no other share of the segment would make smaller."""
    start, step = ends[0], ends[1] - ends[0]
    share, distance = nearest_on_segments(points, start, step)
    assert share.shape == distance.shape == (5, 4)
    assert ((share >= 0) & (share <= 1)).all()
    reached = np.linalg.norm(points - start - share[:, :, None] * step, axis=2)
    assert distance == pytest.approx(reached, abs=1e-9)
    for other in np.linspace(0, 1, 21):
        assert (distance <= np.linalg.norm(points - start - other * step, axis=2) + 1e-9).all()


def test_the_nearest_points_of_a_line_are_on_its_segments_or_corners() -> None:
    """Beside a segment, beyond an end, and outside of a corner."""
    line = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])
    points = np.array([[4.0, 3.0], [-2.0, 1.0], [12.0, -1.0], [9.0, 8.0]])
    found = nearest_on_line_m(points, line)
    assert found.tolist() == [[4.0, 0.0], [0.0, 0.0], [10.0, 0.0], [10.0, 8.0]]


def test_speeds_are_the_mean_of_those_before_and_after() -> None:
    """At the ends that of the only segment; one point has none, and a clock that stands makes no infinity."""
    line = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 6.0]])
    assert speeds_m_s(np.array([0.0, 1.0, 2.0]), line).tolist() == [2.0, 4.0, 6.0]
    assert speeds_m_s(np.zeros(1), line[:1]).tolist() == [0.0]
    assert np.isfinite(speeds_m_s(np.zeros(3), line)).all()

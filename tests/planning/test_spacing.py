"""The 3 m rule keeps what DroneKit's example meant to keep."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from flight_replay.geometry.geodesy import LocalFrame, distance_m
from flight_replay.logs.track import Track, track_from_columns
from flight_replay.planning.spacing import decimate


def track_of(north_east_m: NDArray[np.float64], lat_deg: float = 47.0, lon_deg: float = 8.0) -> Track:
    """A track through points given in metres, one fix a second."""
    lat, lon = LocalFrame(lat_deg, lon_deg).to_degrees(north_east_m)
    return track_from_columns(np.arange(len(lat), dtype=float), lat, lon, np.zeros(len(lat)))


def line(steps_m: list[float]) -> NDArray[np.float64]:
    """Points eastwards, so far apart."""
    return np.column_stack([np.zeros(len(steps_m) + 1), np.concatenate([[0], np.cumsum(steps_m)])])


@pytest.mark.parametrize(
    ("steps_m", "kept"),
    [
        ([], [0]),
        ([1.0], [0, 1]),
        ([0.0], [0, 1]),
        ([0.5] * 10, [0, 7, 10]),
        ([3.1, 3.1], [0, 1, 2]),
        ([2.9, 0.05, 0.1], [0, 3]),
        ([0.0] * 50, [0, 50]),
    ],
    ids=["one fix", "two fixes", "two equal fixes", "half metres", "just beyond", "on the edge", "hovering"],
)
def test_keeps_first_spaced_and_last(steps_m: list[float], kept: list[int]) -> None:
    """The first fix, every one more than 3 m from the last kept, and the last are kept."""
    assert decimate(track_of(line(steps_m))).tolist() == kept


def test_stops_at_the_most_points() -> None:
    """With the budget used up, the rest of the log is left."""
    assert decimate(track_of(line([4.0] * 300)), max_points=100).tolist() == list(range(100))


@pytest.mark.parametrize(
    ("lat_deg", "lon_deg"), [(0.0, 0.0), (60.0, 10.0), (-85.0, 179.99999), (70.0, -180.0)]
)
def test_metres_are_ground_metres_anywhere(lat_deg: float, lon_deg: float) -> None:
    """2.99 m east is not 3 m, 3.01 m is, at any latitude and across the antimeridian."""
    assert decimate(track_of(line([2.99, 4.0]), lat_deg, lon_deg)).tolist() == [0, 2]
    assert decimate(track_of(line([3.01, 4.0]), lat_deg, lon_deg)).tolist() == [0, 1, 2]


@given(
    st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=1, max_size=300),
    st.floats(0.5, 12),
    st.integers(1, 40),
)
def test_rule_holds_for_any_track(
    steps: list[tuple[float, float]], spacing_m: float, max_points: int
) -> None:
    """Order kept, budget kept, first fix kept, and no fix skipped that was far enough."""
    track = track_of(np.cumsum(np.array(steps), axis=0))
    kept = decimate(track, spacing_m, max_points)
    assert kept[0] == 0
    assert len(kept) <= max_points
    assert (np.diff(kept) > 0).all()
    for start, end in pairwise(kept):
        lat, lon = track.lat_deg[start:end], track.lon_deg[start:end]
        between = distance_m(lat[:1], lon[:1], lat[1:], lon[1:])
        assert (between <= spacing_m).all()

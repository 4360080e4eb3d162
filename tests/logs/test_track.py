"""A track is columns that stay together."""

import numpy as np
import pytest

from flight_replay.logs.track import Armed, track_from_columns


def test_selecting_keeps_columns_together() -> None:
    """A mask picks the same fixes of every column."""
    n = 5
    track = track_from_columns(
        np.arange(n, dtype=float), np.linspace(47, 47.1, n), np.full(n, 8.0), np.arange(n) * np.float64(2)
    )
    picked = track.select(np.array([False, True, False, True, False]))
    assert len(picked) == 2
    assert picked.time_s.tolist() == [1, 3]
    assert picked.alt_m.tolist() == [2, 6]
    assert picked.armed.tolist() == [Armed.UNKNOWN] * 2


def test_length_is_ground_metres() -> None:
    """One minute of latitude is about a nautical mile."""
    track = track_from_columns(
        np.zeros(3), np.array([45, 45 + 1 / 60, 45.0]), np.array([8.0, 8, 8]), np.zeros(3)
    )
    assert track.length_m == pytest.approx(2 * 1852, rel=2e-3)


def test_frame_begins_at_the_first_fix() -> None:
    """The first fix is the origin of the track's own frame."""
    track = track_from_columns(np.zeros(2), np.array([1.0, 1.001]), np.array([2.0, 2.0]), np.zeros(2))
    north, east = track.north_east_m()[:, 0], track.north_east_m()[:, 1]
    assert north == pytest.approx([0, 110.574], abs=0.01)
    assert east == pytest.approx([0, 0], abs=1e-6)

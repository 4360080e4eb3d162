"""The recording in local metres: hovers, and the nearest point of its line."""

import numpy as np
import pytest

from flight_replay.planning.fit.reference import hovers, local_track
from tests.helpers.fit_tracks import hover, track_through, wander


def test_hovers_are_found_where_the_vehicle_stood() -> None:
    """Half a minute in the air is one hover; a flight without any has none."""
    found = hovers(local_track(hover(), 20.0), 5)
    assert len(found) == 1
    assert found[0].seconds == pytest.approx(29.75)
    assert hovers(local_track(wander(1), 20.0), 5) == []


def test_the_nearest_place_of_a_recording() -> None:
    """A place beside the line through two fixes is nearest to the line, not to a fix."""
    recording = local_track(track_through(np.array([[0.0, 0], [10, 0]]), np.array([0.0, 5])), 20.0)
    assert np.allclose(recording.nearest_m(np.array([[4.0, 3.0]])), [[4.0, 0.0]], atol=1e-6)

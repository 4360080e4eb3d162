"""The search for the best draft: how far waypoints may stray."""

import numpy as np
import pytest

from flight_replay.planning.fit.reference import local_track
from flight_replay.planning.fit.search import _kept_in_corridor
from tests.helpers.fit_tracks import along, draft_of


def test_no_waypoint_is_farther_than_4_m_from_the_recording() -> None:
    """Places farther away are brought to 4 m, straight towards the recording; the others stay."""
    recording = local_track(along([(0, 0), (60, 0)], 4.0), 20.0)
    draft = draft_of([(0, 0), (20, 3.9), (40, -30), (60, 0)], [False, True, True, True], [1, 0, 0, 0])
    kept = _kept_in_corridor(draft, recording)
    assert kept.places_m[:, :2] == pytest.approx(np.array([[0, 0], [20, 3.9], [40, -4], [60, 0]]), abs=0.01)
    assert (kept.places_m[:, 2] == draft.places_m[:, 2]).all()

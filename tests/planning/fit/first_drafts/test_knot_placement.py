"""Where the waypoints of the even first draft stand."""

import numpy as np

from flight_replay.planning.fit.first_drafts.knot_placement import first_draft
from flight_replay.planning.fit.reference import LocalTrack


def test_a_first_draft_stands_closer_where_it_curves() -> None:
    """More than half of the places go to the curved half of a way."""
    straight = np.column_stack([np.linspace(-120, 0, 100), np.zeros(100)])
    turn = np.linspace(0, 6 * np.pi, 100)
    loops = np.column_stack([6.4 * np.sin(turn), 6.4 * (1 - np.cos(turn))])
    line = np.concatenate([straight, loops])
    recording = LocalTrack(np.arange(200.0) / 3, line, np.full(200, 20.0))
    draft = first_draft(recording, 30, [])
    assert (draft.places_m[:, 0] > -7).sum() > 16

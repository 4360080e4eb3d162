"""Drafts flown in the model, with speeds chosen as legs begin."""

import numpy as np

from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import draft_of


def test_a_choice_of_speeds_is_flown_and_kept() -> None:
    """Speeds chosen as legs begin become the draft's, and fly alike when they are set beforehand."""
    draft = draft_of([(0, 0), (30, 0), (60, 10), (90, 0)], [False, True, True, True], [1, 0, 0, 0])
    asked: list[int] = []

    def choose(place: int, now_s: float) -> float:
        asked.append(place)
        return 2.0 if place < 3 else 4.0

    chosen = simulate_draft(draft, Limits(), 0.05, choose)
    assert sorted(set(asked)) == [1, 2, 3]
    assert chosen.draft.speed_m_s[[1, 3]].tolist() == [2.0, 4.0]
    assert np.isnan(chosen.draft.speed_m_s[[0, 2]]).all()
    again = simulate_draft(chosen.draft, Limits(), 0.05)
    assert np.allclose(again.passed_s, chosen.passed_s)

"""The steps of a search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.reference import local_track
from flight_replay.planning.fit.rounds import changed_flown
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, draft_of

CORNERS = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (40.0, 20.0)]


@pytest.mark.parametrize(("timed", "speeds_m_s"), [(True, [2.0, 1.5]), (False, [1.5])])
def test_changed_drafts_are_flown_at_the_speed_they_have(timed: bool, speeds_m_s: list[float]) -> None:
    """Where the recorded speed is to be kept, at one that keeps it, too."""
    problem = problem_for(local_track(along(CORNERS, 2.0), 20.0), 10, Limits(), timed=timed)
    draft = replace(draft_of(CORNERS, 4 * [False], 4 * [0.0]), speed_m_s=np.full(4, 1.5))
    leave_s = problem.simulate(replace(draft, speed_m_s=np.full(4, 2.0))).passed_s
    found = changed_flown(problem, [(draft, leave_s)])
    assert [float(each.draft.speed_m_s[2]) for each in found] == pytest.approx(speeds_m_s, abs=0.1)

"""The objective of the fit, and where planned paths have the fixes."""

from dataclasses import replace

import numpy as np

from flight_replay.planning.fit.line_simplification import straight_draft
from flight_replay.planning.fit.objective import evaluate, match_to_plan
from flight_replay.planning.fit.reference import LocalTrack, local_track
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import MIXED, along


def test_the_objective_counts_space_plan_and_time() -> None:
    """A flight beside the recording and slower than it costs more in each of its parts."""
    recording = local_track(along([(0, 0), (60, 0)], 4.0), 20.0)
    line = straight_draft(recording, np.array([0, len(recording) - 1]))
    aside = replace(line, places_m=line.places_m + np.array([0.0, 2.0, 0.0]))
    slow = replace(line, speed_m_s=np.array([np.nan, 1.0]))
    good, beside, late = (
        evaluate(simulate_draft(draft, Limits(), 0.05), recording, timed=True)
        for draft in (line, aside, slow)
    )
    assert beside.objective_m > good.objective_m + 2.0
    assert late.objective_m > good.objective_m + 0.5
    early = evaluate(good.flown, replace(recording, time_s=recording.time_s * 3), timed=False)
    assert early.late_m[8:].max() == 0


def test_on_plan_finds_fixes_on_their_legs() -> None:
    """Fixes on the planned path have no distance and lie on the leg that they were taken from."""
    path = MIXED.path(0.001)
    keep = np.arange(0, len(path.seq), 9)
    recording = LocalTrack(keep.astype(float), path.north_east_m[keep], np.zeros(len(keep)))
    leg, _, off, direction = match_to_plan(MIXED, recording)
    assert np.abs(off).max() < 0.05
    assert (np.abs(leg - path.seq[keep]) <= 1).all()
    assert np.allclose(np.linalg.norm(direction[3:], axis=1), 1.0)

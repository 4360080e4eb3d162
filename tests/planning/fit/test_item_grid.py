"""What is found, in the steps in which mission items hold it."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.item_grid import as_items_hold_it
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import flat_frame
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, draft_of, recording_of

FRAME = flat_frame(along([(0, 0), (40, 0)], 4.0))


def problem_and_found(apart_m: float, *, timed: bool = True) -> tuple[FitProblem, Evaluation]:
    """Ten seconds at one place, then a leg; the recording is the draft as it is flown."""
    draft = draft_of([(0, 0), (apart_m, 0), (40, 0)], [False] * 3, [6, 9, 0])
    draft = replace(draft, speed_m_s=np.array([np.nan, 0.7, 4.0]))
    recording = recording_of(simulate_draft(draft, Limits(), 0.02))
    problem = replace(problem_for(recording, 20, Limits(), timed=timed), step_s=0.02)
    return problem, problem.evaluate(draft)


def stored(draft: Draft) -> Draft:
    """The draft as it comes back from its mission."""
    items = [item for _, item in draft.mission(FRAME).waypoints]
    lat, lon = ([round(getattr(item, each), 7) for item in items] for each in ("lat_deg", "lon_deg"))
    places_m = draft.places_m.copy()
    places_m[:, :2] = FRAME.to_metres(lat, lon)
    return replace(draft, places_m=places_m)


def test_a_leg_that_vanishes_in_the_items_makes_nothing_early() -> None:
    """One of 5 mm took a second; without it the wait is longer, so that what follows is on time again."""
    problem, before = problem_and_found(0.005)
    rounded = problem.evaluate(stored(before.draft))
    assert rounded.passed_s[1] == pytest.approx(before.passed_s[1] - 1.0, abs=0.1)
    found = as_items_hold_it(problem, before, FRAME)
    assert found.late_m.mean() < 0.3 * rounded.late_m.mean()
    assert found.draft.places_m[1].tolist() == [0.0, 0.0, 20.0]


@pytest.mark.parametrize("timed", [True, False])
def test_what_is_found_is_measured_as_the_items_fly_it(timed: bool) -> None:
    """A leg of decimetres is as good."""
    problem, before = problem_and_found(0.305, timed=timed)
    found = as_items_hold_it(problem, before, FRAME)
    assert found.draft.places_m[1, 0] != 0.305
    assert found.draft.places_m == pytest.approx(stored(found.draft).places_m, abs=1e-5)
    assert found.draft.hold_s.tolist() == [6.0, 9.0, 0.0]

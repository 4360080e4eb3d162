"""Legs on which ArduPilot reports an internal error are mended."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.mends.leg_errors import without_errors
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import local_track
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, draft_of

CORNERS = [(0.0, 0.0), (-0.31, -0.28), (-4.65, -0.17), (-1.88, -3.93), (0.98, -5.23)]
"""4.6 reported one on such a straight leg of 0.42 m, at 0.35 m/s, before a curve."""


def evaluated(*, timed: bool) -> tuple[FitProblem, Evaluation]:
    recording = local_track(along(CORNERS, 1.0), 20.0)
    problem = problem_for(recording, 10, Limits(), timed=timed)
    draft = draft_of(CORNERS, [False, False, True, True, True], [6, 0, 0, 0, 0])
    return problem, problem.exact.evaluate(
        replace(draft, speed_m_s=np.array([np.nan, 0.35, 1.19, 2.23, 2.65]))
    )


@pytest.mark.parametrize("timed", [True, False])
def test_a_leg_with_an_error_is_mended(timed: bool) -> None:
    """By little, as another length is enough."""
    problem, best = evaluated(timed=timed)
    assert best.flight.has_error
    mended = without_errors(problem, best)
    assert not mended.flight.has_error
    assert mended.objective_m < 1.2 * best.objective_m
    assert len(mended.draft) in (4, 5)


def test_a_leg_to_a_wait_is_mended() -> None:
    """A straight leg behind a curve, at twice its speed; what is waited stays."""
    places = [(0.0, 0.0), (2.0, 0.0), (2.6, 0.5), (2.6, 1.48), (6.0, 3.0)]
    recording = local_track(along(places, 0.7), 20.0)
    problem = problem_for(recording, 10, Limits(), timed=True)
    draft = draft_of(places, [False, True, True, False, True], [6, 0, 0, 2, 0])
    best = problem.exact.evaluate(replace(draft, speed_m_s=np.array([np.nan, 0.35, 0.35, 0.7, 2.0])))
    assert best.flight.has_error
    mended = without_errors(problem, best)
    assert not mended.flight.has_error
    assert mended.draft.hold_s.tolist() == draft.hold_s.tolist()


def test_a_draft_without_an_error_stays_as_it_is() -> None:
    """Though it has short legs."""
    problem, best = evaluated(timed=False)
    mended = without_errors(problem, best)
    assert without_errors(problem, mended) is mended


def test_what_cannot_be_mended_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is told by the prediction then."""
    problem, best = evaluated(timed=False)
    monkeypatch.setattr("flight_replay.planning.fit.mends.leg_errors._SHORT_M_PER_M_S3", 0.1)
    assert without_errors(problem, best) is best


def test_a_change_that_does_not_end_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fit is what it was before."""
    problem, best = evaluated(timed=False)

    def refuse(*_: object) -> None:
        raise MissionError("the fitted flight does not end")

    monkeypatch.setattr("flight_replay.planning.fit.rounds.flown_leaving", refuse)
    assert without_errors(problem, best) is best


def test_the_leg_to_where_the_vehicle_comes_to_rest_behind_a_last_curve_is_mended() -> None:
    """AUTO makes it, and in long steps of the model it may have no error."""
    recording = local_track(along([(0.0, 0.0), (50.0, 0.0), (50.0, 40.0)], 3.0), 30.0)
    problem = problem_for(recording, 10, Limits(), timed=False)
    places = [(0.0, 0.0), (49.9747812, 0.0), (49.99715328, 40.00167448)]
    best = problem.evaluate(draft_of(places, [False, True, True], [1, 10, 0]))
    fine = replace(problem, step_s=0.02)
    assert fine.evaluate(best.draft).flight.has_error
    mended = without_errors(problem, best)
    assert not fine.evaluate(mended.draft).flight.has_error
    assert not mended.draft.spline[-1] or mended.draft.hold_s[-1]
    assert mended.objective_m < 1.2 * best.objective_m

"""Curves that ArduPilot may leap through are mended."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.mends.curve_leaps import places_before_leaps, without_leaps
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import local_track
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, draft_of

CORNERS = [(0.0, 0.0), (1.0, 0.5), (2.0, 1.5), (2.1, 2.5), (2.2, 3.5), (5.0, 5.0)]
CURVED = [False, True, False, True, False, True]
"""4.6 leapt through curves of 0.2 to 0.5 m like that to the fourth of these places, and to the last."""


def draft(waits: list[float], speed_m_s: float = 0.35) -> Draft:
    speeds_m_s = np.array([np.nan, speed_m_s, *[np.nan] * 4])
    return replace(draft_of(CORNERS, CURVED, waits), speed_m_s=speeds_m_s)


def evaluated(waits: list[float]) -> tuple[FitProblem, Evaluation]:
    problem = problem_for(local_track(along(CORNERS, 0.35), 20.0), 10, Limits(), timed=True)
    return problem, problem.exact.evaluate(draft(waits))


@pytest.mark.parametrize(
    ("waits", "places"),
    [
        ([6, 0, 3, 0, 3, 0], [2, 4]),
        ([6, 2, 3, 0, 0, 0], []),  # From rest, and flown through.
        ([6, 0, 0, 0, 0, 3], []),
        ([6, 3, 0, 3, 0, 0], []),  # Reached on curves.
    ],
)
def test_slow_straight_legs_in_motion_to_a_stop_before_a_curve_are_found(
    waits: list[float], places: list[int]
) -> None:
    """Others leave no speed at all, or so much that the curve is flown as in the model."""
    assert places_before_leaps(draft(waits)) == places
    assert places_before_leaps(draft(waits, 0.6)) == []


def test_a_stop_that_is_left_straight_is_none() -> None:
    """SCurve begins from rest whatever is left."""
    straight = replace(draft([6, 0, 3, 0, 3, 0]), spline=np.array([False, True, False, False, False, False]))
    assert places_before_leaps(straight) == []


def test_such_stops_are_mended() -> None:
    """Each on its own, and by little."""
    problem, best = evaluated([6, 0, 3, 0, 3, 0])
    mended = without_leaps(problem, best)
    assert places_before_leaps(mended.draft) == []
    assert len(mended.draft) == len(best.draft)
    assert mended.objective_m < 1.3 * best.objective_m


def test_a_stop_that_is_reached_sooner_waits_longer() -> None:
    """The other speeds, which were found together, are kept, and what follows begins when it did."""
    problem, best = evaluated([6, 0, 3, 0, 3, 0])
    mended = without_leaps(problem, best)
    assert mended.draft.hold_s[4] > best.draft.hold_s[4]
    assert mended.passed_s[4] == pytest.approx(best.passed_s[4], abs=0.6)


def test_a_draft_without_such_stops_stays_as_it_is() -> None:
    """Nothing is flown for it."""
    problem, best = evaluated([6, 2, 3, 0, 0, 0])
    assert without_leaps(problem, best) is best


def test_what_cannot_be_mended_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """A change that does not end is none."""
    problem, best = evaluated([6, 0, 3, 0, 3, 0])

    def refuse(*_: object) -> None:
        raise MissionError("the fitted flight does not end")

    monkeypatch.setattr(FitProblem, "compared", refuse)
    assert without_leaps(problem, best) is best

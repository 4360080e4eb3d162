"""Descents much faster than the vehicle may descend are mended."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.logs.track import Track
from flight_replay.planning.dives import falls_m_s, too_fast_m_s
from flight_replay.planning.fit import fit
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.mends.spline_dives import without_dives
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import local_track
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import draft_of, track_through

HIGH_M, LOW_M, FAR_M = 20.0, 5.0, 40.0
LIMITS = Limits(wp_speed_down_m_s=0.8)
TOO_FAST_M_S = too_fast_m_s(LIMITS)
PLACES_M = [
    (-30.16, -29.29), (-23.74, -28.77), (-17.39, -26.69), (-12.38, -23.79), (-8.54, -20.21),
    (-3.8, -14.22), (-1.32, -6.07), (0.03, -2.21), (0.09, -0.76), (0.0, 0.0),
]  # fmt: skip
HEIGHTS_M = [HIGH_M] * 7 + [HIGH_M - 0.7, HIGH_M, LOW_M]
"""A curve that leads straight down from a level one: 4.6 fell at 4.4 m/s behind such."""


def ends_straight_down() -> Track:
    """A flight around a bend, and down where it ends."""
    time_s = np.arange(0.0, 24.0, 0.25)
    turn = np.minimum(3.0 * time_s, FAR_M) / 25.0
    up_m = np.clip(HIGH_M - 1.5 * (time_s - FAR_M / 3.0), LOW_M, HIGH_M)
    return track_through(25.0 * np.column_stack([np.sin(turn), 1.0 - np.cos(turn)]), time_s, up_m)


def evaluated(*, timed: bool, falls: int = 1) -> tuple[FitProblem, Evaluation]:
    """Such a curve, once or twice, in the model."""
    track = ends_straight_down()
    problem = problem_for(local_track(track, track.alt_m), 10, LIMITS, timed=timed)
    places_m = [(north + 60.0 * nth, east) for nth in range(falls) for north, east in PLACES_M]
    later = len(places_m) - 1
    draft = draft_of(places_m, [False] + [True] * later, [6.0] + [0.0] * later)
    at_heights_m = np.column_stack([draft.places_m[:, :2], HEIGHTS_M * falls])
    return problem, problem.exact.evaluate(replace(draft, places_m=at_heights_m))


def worst_m_s(evaluation: Evaluation) -> float:
    flight = evaluation.flight
    return float(falls_m_s(flight.time_s, flight.place_m[:, 2]).max())


@pytest.mark.parametrize("falls", [1, 2])
@pytest.mark.parametrize("timed", [True, False])
def test_a_dive_is_mended(timed: bool, falls: int) -> None:
    """One after the other; it costs little."""
    problem, best = evaluated(timed=timed, falls=falls)
    assert worst_m_s(best) > TOO_FAST_M_S
    mended = without_dives(problem, best)
    assert worst_m_s(mended) <= TOO_FAST_M_S
    assert len(mended.draft) == len(best.draft)
    assert mended.objective_m < 1.2 * best.objective_m


def test_a_draft_without_a_dive_stays_as_it_is() -> None:
    """Though it comes down."""
    problem, best = evaluated(timed=False)
    mended = without_dives(problem, best)
    assert without_dives(problem, mended) is mended


def test_changes_that_do_not_end_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fit is what it was before, and the prediction tells of the dive."""
    problem, best = evaluated(timed=False)

    def refuse(*_: object) -> None:
        raise MissionError("the fitted flight does not end")

    monkeypatch.setattr("flight_replay.planning.fit.rounds.flown_leaving", refuse)
    assert without_dives(problem, best) is best


def test_a_fit_of_a_flight_that_ends_straight_down_does_not_dive() -> None:
    """At recorded heights, as of most whole flights; unmended it would fall at 2 m/s."""
    limits = Limits(wp_speed_down_m_s=0.5)
    found = fit(ends_straight_down(), max_points=6, altitude_m="recorded", limits=limits)
    falls = falls_m_s(found.flight.time_s, found.flight.place_m[:, 2])
    assert falls.max() <= too_fast_m_s(limits)

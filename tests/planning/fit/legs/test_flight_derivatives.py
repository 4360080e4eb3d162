"""The derivatives of a draft's flight foretell what small changes of it do."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.lateness import places_at, position_offsets_m
from flight_replay.planning.fit.legs.flight_derivatives import (
    HOLD,
    SPEED,
    ErrorVectors,
    FlightDerivatives,
    changes_of,
    flight_derivatives,
)
from flight_replay.planning.fit.legs.local_flights import LocalFlight, LocalFlights
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import local_track
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, draft_of

DRAFT = replace(
    draft_of(
        [(0, 0), (30, 0), (60, 10), (90, 0), (120, 0)], [False, True, True, True, True], [1, 0, 0, 0, 0]
    ),
    speed_m_s=np.array([np.nan, 4.0, 5.0, 4.0, 5.0]),
)
PROBLEM = replace(
    problem_for(local_track(along([(0, 0), (60, 8), (120, 0)], 4.0), 20.0), 20, Limits(), timed=True),
    step_s=0.02,
)
BASE = PROBLEM.evaluate(DRAFT)


CHANGES_A_PLACE = 3


def position(problem: FitProblem, evaluation: Evaluation) -> Floats:
    return position_offsets_m(evaluation.flight, problem.recording)


@pytest.mark.parametrize(("place", "change", "size"), [(2, 0, 0.05), (2, 1, 0.3), (3, 2, -0.3), (4, 0, 0.05)])
def test_a_small_change_does_what_the_derivatives_say(place: int, change: int, size: float) -> None:
    """Errors at equal times, beside the path and the times of passing are foretold to a fifth."""
    derivatives = flight_derivatives(PROBLEM, BASE, 600.0, np.sign(size))
    trial = PROBLEM.evaluate(changed(place, change, size))
    column = (place - 1) * CHANGES_A_PLACE + change
    foretold = size * derivatives.at_fixes[:, column].reshape(-1, 2)
    done = position(PROBLEM, trial) - position(PROBLEM, BASE)
    moving = PROBLEM.recording.time_s < BASE.passed_s[-1] - 1.0
    assert np.abs(foretold - done)[moving].max() < 0.2 * np.abs(done[moving]).max() + 0.05
    passed_s = size * derivatives.passed_s[:, column]
    assert np.abs(passed_s - (trial.passed_s - BASE.passed_s)).max() < 0.02


def test_a_longer_wait_makes_all_that_follows_later() -> None:
    """At a place in between; the first is waited at before the clock runs, the last after all."""
    waits = np.array([6.0, 0.0, 4.0, 0.0, 3.0])
    base = PROBLEM.evaluate(replace(DRAFT, hold_s=waits))
    kinds, places = changes_of(base.draft, timed=True)
    assert places[kinds == HOLD].tolist() == [2]
    assert HOLD not in changes_of(base.draft, timed=False)[0]
    derivatives = flight_derivatives(PROBLEM, base, 600.0)
    (column,) = np.flatnonzero(kinds == HOLD)
    trial = PROBLEM.evaluate(replace(base.draft, hold_s=waits + np.array([0, 0, 1, 0, 0])))
    assert derivatives.passed_s[:, column] == pytest.approx(trial.passed_s - base.passed_s, abs=0.03)
    count = len(PROBLEM.recording)
    foretold = errors_of(derivatives)[:, column].reshape(-1, 2)
    left = PROBLEM.recording.time_s > base.passed_s[2]
    at_s, flight = PROBLEM.recording.time_s, base.flight
    sooner, later = (places_at(flight.time_s, flight.place_m[:, :2], at_s + s) for s in (-0.2, 0.2))
    assert foretold[:count][left] == pytest.approx(((sooner - later) / 0.4)[left], abs=0.2)
    assert not foretold[:count][~left].any()
    assert not foretold[count:].any()


def test_times_of_passing_are_finer_than_the_steps_of_the_model() -> None:
    """A change of milliseconds is seen in steps of twenty, but for stops, which end with a step."""
    small, usual = (flight_derivatives(PROBLEM, BASE, 600.0, size).passed_s[:-1] for size in (0.05, 0.1))
    assert np.abs(small - usual).max() < 0.1 * np.abs(usual).max()


@pytest.mark.parametrize(("place", "change"), [(2, 0), (2, 1), (3, 2)])
def test_errors_beside_the_paths_are_foretold(place: int, change: int) -> None:
    """Those of the fixes beside the flown and the planned path, and of the flown path's own points."""
    derivatives = flight_derivatives(PROBLEM, BASE, 600.0, 0.25)
    size = 0.02 if change == 0 else 0.1
    foretold_m = size * errors_of(derivatives)[:, (place - 1) * CHANGES_A_PLACE + change].reshape(-1, 2)
    trial, count = PROBLEM.evaluate(changed(place, change, size)), len(PROBLEM.recording)
    for first, now, before in (
        (count, trial.flown[0].off_m, BASE.flown[0].off_m),
        (2 * count, trial.planned[0].off_m, BASE.planned[0].off_m),
    ):
        # The fixes at the ends are beside a path that may be shorter or longer.
        some = slice(5, -5)
        done_m = np.linalg.norm(now, axis=1)[some] - np.linalg.norm(before, axis=1)[some]
        there_m = np.linalg.norm(before + foretold_m[first : first + count], axis=1)[some]
        assert np.abs(there_m - np.linalg.norm(before, axis=1)[some] - done_m).max() < 0.015
    assert len(foretold_m) == 3 * count + len(BASE.flown[1].off_m)


@pytest.mark.parametrize("north", [True, False])
def test_at_the_vehicles_own_speed_the_planned_paths_points_count_too(north: bool) -> None:
    """No speed changes, and the last place stays: two columns for each of the others."""
    problem = replace(PROBLEM, timed=False)
    base = problem.evaluate(replace(DRAFT, speed_m_s=np.full(len(DRAFT), np.nan)))
    derivatives = flight_derivatives(problem, base, 600.0, 0.25)
    kinds, places = changes_of(DRAFT, timed=False)
    assert SPEED not in kinds
    assert errors_of(derivatives).shape[1] == len(places) == 2 * (len(DRAFT) - 2)
    place, axis = 2, 0 if north else 1
    places_m = base.draft.places_m.copy()
    places_m[place, axis] += 0.1
    now = problem.evaluate(replace(base.draft, places_m=places_m)).planned[1].off_m[5:-5]
    before = base.planned[1].off_m
    foretold_m = (
        before + 0.1 * errors_of(derivatives)[:, 2 * (place - 1) + axis].reshape(-1, 2)[-len(before) :]
    )
    assert np.abs(np.linalg.norm(foretold_m[5:-5], axis=1) - np.linalg.norm(now, axis=1)).max() < 0.03


def test_moves_of_the_paths_points_follow_those_of_the_fixes() -> None:
    """They are the last of the stacked errors."""
    one, two = np.ones((4, 2)), np.ones((3, 2))
    errors = ErrorVectors(one, one, one, one, two)
    flown, planned = errors.moved_back(np.arange(errors.stacked.size, dtype=float))
    assert flown[0].tolist() == [25.0, 26.0]
    assert planned[-1].tolist() == [37.0, 38.0]


def errors_of(derivatives: FlightDerivatives) -> Floats:
    return np.concatenate([derivatives.at_fixes, derivatives.beside])


def changed(place: int, change: int, size: float) -> Draft:
    draft = with_every_speed(DRAFT)
    if change == 0:
        speeds = draft.speed_m_s.copy()
        speeds[place] *= np.exp(size)
        return replace(draft, speed_m_s=speeds)
    places = draft.places_m.copy()
    places[place, change - 1] += size
    return replace(draft, places_m=places)


def test_a_change_that_cannot_be_flown_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Legs that do not end have no derivatives."""
    fly = LocalFlights.fly

    def refuse(flights: LocalFlights, draft: Draft, first: int, last: int) -> LocalFlight:
        if draft is not flights.draft and first == 2:
            raise MissionError("a leg of the fitted flight does not end")
        return fly(flights, draft, first, last)

    monkeypatch.setattr(LocalFlights, "fly", refuse)
    derivatives = flight_derivatives(PROBLEM, BASE, 600.0)
    moved = np.abs(errors_of(derivatives)).max(axis=0).reshape(-1, CHANGES_A_PLACE)
    assert moved[1, 0] == 0.0
    assert (moved[0] > 0).all()

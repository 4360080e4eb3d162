"""Parts of a flight are those of the whole flight, and what is changed is flown from there."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.legs.leg_moves import with_better_legs
from flight_replay.planning.fit.legs.local_flights import LocalFlights
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import local_track
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, budget, draft_of

DRAFT = draft_of(
    [(0, 0), (30, 0), (60, 10), (90, 0), (120, 0)], [False, True, True, False, True], [1, 0, 0, 3, 0]
)


def problem(*, timed: bool = False) -> FitProblem:
    recording = local_track(along([(0, 0), (60, 0), (60, 60)], 4.0), 20.0)
    return problem_for(recording, 20, Limits(), timed=timed)


def test_legs_are_flown_as_in_the_whole_flight() -> None:
    """Each leg that is flown by itself passes the same places at the same times."""
    fit = problem()
    whole = fit.simulate(DRAFT)
    flights = LocalFlights(fit, DRAFT, 600.0)
    for first, last in ((1, 2), (2, 4), (1, 4)):
        part = flights.fly(DRAFT, first, last)
        there = [np.interp(part.time_s, whole.time_s, axis) for axis in whole.place_m[:, :2].T]
        off_m = np.abs(part.north_east_m - np.column_stack(there))
        assert off_m[: part.ended].max() < 1e-9
    assert flights.steps > 0


def test_legs_that_do_not_end_are_refused() -> None:
    """A trial that takes longer than it may is an error that its caller turns down."""
    flights = LocalFlights(problem(), DRAFT, 600.0)
    flights._most_steps = 10
    with pytest.raises(MissionError, match="does not end"):
        flights.fly(DRAFT, 1, 2)


def test_a_flight_goes_on_until_the_vehicle_is_where_its_target_was() -> None:
    """A second is flown beyond the last place, of the draft itself and of others alike."""
    flights = LocalFlights(problem(), DRAFT, 600.0)
    same = replace(DRAFT)
    for draft in (DRAFT, same):
        part = flights.fly(draft, 1, 1)
        assert part.time_s[-1] - part.left_s == pytest.approx(1.0, abs=0.05)
    assert (flights.fly(DRAFT, 1, 2).north_east_m == flights.fly(same, 1, 2).north_east_m).all()


def test_better_legs_cost_less() -> None:
    """A corner that is flown around a curve far outside is flown nearer to it."""
    fit = problem()
    draft = draft_of([(0, 0), (60, 0), (60, 60)], [False, True, True], [1, 0, 0])
    start = fit.evaluate(draft)
    better = fit.evaluate(with_better_legs(fit, start, {}, budget(100)))
    assert better.objective_m < 0.8 * start.objective_m
    assert not better.draft.spline.all()

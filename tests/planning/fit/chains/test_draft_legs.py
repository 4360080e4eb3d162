"""What legs of drafts cost, at the recorded and at the vehicle's own speed."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.planning.fit.chains.draft_legs import LegCosts
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.objective import Evaluation, leg_costs_m, seconds_cost_m_s
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import local_track
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along


def problem(*, timed: bool) -> FitProblem:
    return problem_for(local_track(along([(0.0, 0.0), (200.0, 0.0)], 4.0), 20.0), 20, Limits(), timed=timed)


def flown_at(problem: FitProblem, speed_m_s: float) -> Evaluation:
    places = np.column_stack([np.linspace(0.0, 200.0, 11), np.zeros(11), np.full(11, 20.0)])
    hold_s = np.append(1.0, np.zeros(10))
    return problem.evaluate(Draft(places, hold_s == 0, hold_s, np.append(speed_m_s, np.full(10, np.nan))))


def test_at_the_recorded_speed_being_late_costs_where_it_is() -> None:
    """Leg by leg, as the objective adds it up."""
    here = problem(timed=True)
    slow = flown_at(here, 2.0)
    costs = LegCosts(here, slow)
    assert costs.costs_m(slow).tolist() == leg_costs_m(slow, costs.scales_m, whole=True).tolist()


def test_at_the_vehicles_own_speed_seconds_cost_where_what_follows_is_late() -> None:
    """The same path at half the recorded speed, and at twice that, of which nothing is late."""
    here = problem(timed=False)
    slow, fast = flown_at(here, 2.0), flown_at(here, 8.0)
    costs = LegCosts(here, slow)
    path_m = leg_costs_m(slow, costs.scales_m, whole=False)
    second_m_s = np.interp(slow.passed_s, here.recording.time_s, seconds_cost_m_s(slow, here.recording))
    lasts_s = np.diff(slow.passed_s, prepend=0.0)
    assert second_m_s[1] > 0.01
    assert costs.costs_m(slow) == pytest.approx(path_m + second_m_s * lasts_s)
    never_late = replace(fast, late_off_m=np.zeros_like(fast.late_off_m))
    assert LegCosts(here, never_late).costs_m(never_late).sum() == pytest.approx(
        leg_costs_m(fast, costs.scales_m, whole=False).sum(), abs=1e-6
    )


def test_seconds_cost_what_they_do_on_average_of_the_drafts_that_were_flown() -> None:
    """One that is late everywhere and one that is late nowhere: half."""
    here = problem(timed=False)
    slow, fast = flown_at(here, 2.0), flown_at(here, 8.0)
    costs = LegCosts(here, slow)
    path_m = leg_costs_m(slow, costs.scales_m, whole=False)
    before_m = costs.costs_m(slow) - path_m
    costs.learn(replace(fast, late_off_m=np.zeros_like(fast.late_off_m)))
    assert costs.costs_m(slow) - path_m == pytest.approx(before_m / 2)

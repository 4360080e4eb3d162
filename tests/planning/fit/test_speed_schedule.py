"""Lateness that a vehicle cannot avoid, spread where it costs least."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.offsets import match_to_plan
from flight_replay.planning.fit.reference import hovers
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.planning.fit.speed_schedule import best_lateness_s, recorded_passing_s, slowest_m_s
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import draft_of, recording_of


def test_lateness_is_spread_where_it_costs_least() -> None:
    """A stretch that takes 2 s too long is entered early and left late, not late all the way after."""
    wanted = np.array([0.0, 4, 4, 2, 4, 4])
    least = np.array([0.0, 2, 2, 4, 2, 2])
    late = best_lateness_s(wanted, least, np.ones(6))
    assert (np.diff(late) >= least[1:] - wanted[1:] - 1e-9).all()
    assert np.abs(late).sum() == pytest.approx(2.0)


def test_no_lateness_where_the_vehicle_keeps_up() -> None:
    """Legs that can be flown in time are."""
    assert np.allclose(best_lateness_s(np.full(5, 3.0), np.full(5, 2.0), np.ones(5)), 0.0)


def test_lateness_that_cannot_be_made_good_stays() -> None:
    """A route that is too fast from end to end is ever later."""
    late = best_lateness_s(np.full(4, 1.0), np.full(4, 3.0), np.ones(4))
    assert late.tolist() == [0, 2, 4, 6]


def test_between_two_waits_a_vehicle_is_not_asked_to_creep() -> None:
    """There is time enough at both ends; where one is flown through, a slow leg may be what was recorded."""
    hold_s = np.array([1.0, 3.0, 0.0, 2.0, 4.0])
    draft = Draft(np.zeros((5, 3)), np.zeros(5, np.bool_), hold_s, np.full(5, np.nan))
    assert slowest_m_s(draft).tolist() == [0.35, 0.7, 0.35, 0.35, 0.7]


@pytest.mark.parametrize("speed_m_s", [3.0, 8.0])
def test_a_hover_is_left_when_the_recorded_vehicle_began_to_leave_it(speed_m_s: float) -> None:
    """It was on its way for more than a second as it left the circle in which it hovered."""
    draft = draft_of([(0, 0), (40, 0), (40, 60)], [False] * 3, [6, 9, 0])
    flight = simulate_draft(replace(draft, speed_m_s=np.array([np.nan, 3.0, speed_m_s])), Limits(), 0.02)
    recording = recording_of(flight)
    (hover, *_) = hovers(recording, 2)
    assert recording.time_s[hover.last] > flight.passed_s[1] + 1.0
    planned, _ = match_to_plan(draft, recording)
    passing_s = recorded_passing_s(planned, len(draft), {1: hover}, recording)
    assert passing_s[1] == pytest.approx(flight.passed_s[1], abs=0.5)

"""Drafts flown in the model."""

import numpy as np
import pytest

from flight_replay.planning.fit.simulated_draft import items_of, simulate_draft
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import draft_of

DRAFT = draft_of([(0, 0), (30, 0), (60, 10), (90, 0)], [False, True, True, True], [1, 0, 0, 0])


def test_a_flight_begins_at_the_first_place_and_passes_all() -> None:
    """Times count from the first place, and every place is passed in order."""
    flight = simulate_draft(DRAFT, Limits(), 0.05)
    assert flight.time_s[0] == flight.passed_s[0] == 0.0
    assert (np.diff(flight.passed_s) > 0).all()
    assert flight.place_m[-1] == pytest.approx(DRAFT.places_m[-1], abs=2.5)


def test_speeds_before_every_leg_change_the_numbers_of_the_places() -> None:
    """Items count from 1; with a speed for every leg but the first, places are every second one."""
    assert items_of(DRAFT)[1] == [1, 2, 3, 4]
    assert items_of(DRAFT, every_speed=True)[1] == [1, 3, 5, 7]

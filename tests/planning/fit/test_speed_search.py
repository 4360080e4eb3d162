"""Speeds found leg after leg: places are left when they ought to be, exactly as they fly afterwards."""

import numpy as np

from flight_replay.planning.fit.reference import AT_SEA_LEVEL
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.planning.fit.speed_schedule import Schedule, with_speeds
from flight_replay.planning.fit.speed_search import SpeedSearch
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import draft_of

DRAFT = draft_of(
    [(0, 0), (30, 0), (60, 10), (90, 0), (120, 0)], [False, True, True, True, True], [1, 0, 0, 3, 0]
)
CAPS_M_S = np.full(5, 8.0)


def searched(leave_s: list[float], step_s: float = 0.05) -> SpeedSearch:
    return SpeedSearch(Schedule(DRAFT, np.array(leave_s)), CAPS_M_S, Limits(), step_s, AT_SEA_LEVEL)


def test_places_are_left_on_time() -> None:
    """Times that a vehicle can keep are kept to 0.1 s, waiting included."""
    leave_s = [0.0, 14.0, 24.0, 40.0, 56.0]
    search = searched(leave_s)
    flight = search.run()
    assert np.isnan(flight.draft.speed_m_s[0])
    assert np.abs(flight.passed_s - leave_s).max() <= 0.1
    assert search.steps > 0


def test_the_flight_is_that_of_the_draft_with_its_speeds() -> None:
    """What the search has flown leg after leg is what the model flies at once, to the last bit."""
    found = searched([0.0, 14.0, 24.0, 40.0, 56.0]).run()
    again = simulate_draft(found.draft, Limits(), 0.05)
    assert (found.place_m == again.place_m).all()
    assert (found.passed_s == again.passed_s).all()


def test_a_draft_that_is_on_time_is_flown_once() -> None:
    """Each leg is tried at its own speed first, and no other where that will do."""
    leave_s = np.array([0.0, 14.0, 24.0, 40.0, 56.0])
    found = SpeedSearch(Schedule(DRAFT, leave_s), CAPS_M_S, Limits(), 0.05, AT_SEA_LEVEL).run()
    again = SpeedSearch(Schedule(found.draft, leave_s), CAPS_M_S, Limits(), 0.05, AT_SEA_LEVEL)
    assert (again.run().place_m == found.place_m).all()
    assert again.steps <= len(found.time_s) + 100


def test_a_vehicle_that_cannot_keep_up_flies_as_fast_as_it_can() -> None:
    """Where every place ought to be left at once, no speed is below what would be sooner."""
    hurried = searched([0.0, 0.1, 0.2, 3.3, 3.4]).run()
    fastest = simulate_draft(with_speeds(DRAFT, CAPS_M_S), Limits(), 0.05)
    assert hurried.passed_s[-1] <= fastest.passed_s[-1] + 0.3


def test_no_speed_is_below_what_arducopter_takes() -> None:
    """However late a place is to be left, ArduCopter ignores speeds below 0.2 m/s."""
    slow = searched([0.0, 500.0, 510.0, 520.0, 530.0], 0.1).run()
    assert np.nanmin(slow.draft.speed_m_s) >= 0.25

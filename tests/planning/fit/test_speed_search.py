"""Speeds found leg after leg: places are left when they ought to be, exactly as they fly afterwards."""

import numpy as np

from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.planning.fit.speed_schedule import Schedule, with_speeds
from flight_replay.planning.fit.speed_search import SpeedSearch
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import draft_of

DRAFT = draft_of(
    [(0, 0), (30, 0), (60, 10), (90, 0), (120, 0)], [False, True, True, True, True], [1, 0, 0, 3, 0]
)
CAPS_M_S = np.full(5, 8.0)


def passed_s(speeds_m_s: np.ndarray) -> np.ndarray:
    return simulate_draft(with_speeds(DRAFT, speeds_m_s), Limits(), 0.05).passed_s


def test_places_are_left_on_time() -> None:
    """Times that a vehicle can keep are kept to 0.1 s, waiting included."""
    leave_s = np.array([0.0, 14.0, 24.0, 40.0, 56.0])
    search = SpeedSearch(Schedule(DRAFT, leave_s), CAPS_M_S, Limits(), 0.05, 0.0)
    speeds = search.run()
    assert np.isnan(speeds[0])
    assert np.abs(passed_s(speeds) - leave_s).max() <= 0.1
    assert search.steps > 0


def test_a_vehicle_that_cannot_keep_up_flies_as_fast_as_it_can() -> None:
    """Where every place ought to be left at once, no speed is below what would be sooner."""
    leave_s = np.array([0.0, 0.1, 0.2, 3.3, 3.4])
    hurried = SpeedSearch(Schedule(DRAFT, leave_s), CAPS_M_S, Limits(), 0.05, 0.0).run()
    assert passed_s(hurried)[-1] <= passed_s(CAPS_M_S)[-1] + 0.3


def test_no_speed_is_below_what_arducopter_takes() -> None:
    """However late a place is to be left, ArduCopter ignores speeds below 0.2 m/s."""
    leave_s = np.array([0.0, 500.0, 510.0, 520.0, 530.0])
    speeds = SpeedSearch(Schedule(DRAFT, leave_s), CAPS_M_S, Limits(), 0.1, 0.0).run()
    assert np.nanmin(speeds) >= 0.25

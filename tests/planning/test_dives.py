"""A predicted flight that falls out of a curve is told."""

import numpy as np

from flight_replay.geometry.movement import Movement
from flight_replay.planning.dives import dive_note
from flight_replay.simulator.dynamics.limits import Limits


def descending(rate_m_s: float, seconds: float) -> Movement:
    """A minute at 60 m, then straight down at a rate for some seconds, then level."""
    time_s = np.arange(-5.0, 100.0, 0.1)
    up_m = 60.0 - rate_m_s * np.clip(time_s - 60.0, 0.0, seconds)
    return Movement(time_s, np.zeros((len(time_s), 2)), up_m, np.zeros(len(time_s)))


def test_a_fall_that_the_vehicle_may_not_fly_is_told() -> None:
    """4.6 fell from 60 m to 6 m at up to 8 m/s, behind a recording that it could not keep up with."""
    note = dive_note(descending(5.0, 10.0), Limits())
    assert "fall out of a curve at 5 m/s, 60 s after the first waypoint" in note
    assert "limited to 1.5 m/s" in note


def test_a_descent_that_the_vehicle_may_fly_is_none() -> None:
    """At its limit, at a limit that is raised, for a moment only, or as there is no flight of a second."""
    assert dive_note(descending(1.5, 10.0), Limits()) == ""
    assert dive_note(descending(5.0, 10.0), Limits(wp_speed_down_m_s=4.0)) == ""
    assert dive_note(descending(4.0, 0.5), Limits()) == ""
    assert dive_note(descending(5.0, 10.0).select(slice(650, 655)), Limits()) == ""

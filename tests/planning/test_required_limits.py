"""The limits that a vehicle needs to fly as recorded."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.required_limits import required_limits
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import (
    along,
    circle,
    sped_up,
)


def test_limits_are_raised_to_the_recording_and_never_lowered() -> None:
    """A circle flown at 4.5 m/s² needs twice that and more; a slow one needs nothing."""
    fast = required_limits(sped_up(circle(20.0, 3.0, laps=2), 3.16), Limits())
    assert 9.0 < fast["wp_accel_m_s2"] < 13.0
    assert fast["wp_jerk_m_s3"] == fast["wp_accel_m_s2"]
    assert Limits().lean_angle_rad < fast["lean_angle_rad"] < np.pi / 4 + 1e-9
    assert "wp_accel_m_s2" not in required_limits(circle(20.0, 3.0), Limits())
    assert "wp_speed_m_s" in required_limits(along([(0, 0), (400, 0)], 15.0), Limits())


def test_limits_use_recorded_velocities_where_there_are_some() -> None:
    """Climb rates come from the log's own velocities; a track of one fix raises nothing."""
    track = along([(0, 0), (60, 0)], 3.0)
    rate: Floats = np.full(len(track), 4.0)
    climbing = replace(track, up_m_s=rate, north_m_s=rate, east_m_s=0 * rate)
    assert required_limits(climbing, Limits())["wp_speed_up_m_s"] == pytest.approx(4.8)
    assert required_limits(track.select(slice(0, 1)), Limits()) == {}

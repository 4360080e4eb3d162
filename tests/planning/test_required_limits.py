"""The limits that a vehicle needs to fly as recorded."""

from dataclasses import replace
from math import atan, pi

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.track import Armed, Track
from flight_replay.planning.required_limits import required_limits
from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2, Limits
from tests.helpers.fit_tracks import along, circle, joined, sped_up, track_through

NONE = Limits(
    wp_speed_m_s=0.0,
    wp_accel_m_s2=0.0,
    wp_jerk_m_s3=0.0,
    shaping_jerk_m_s3=0.0,
    lean_angle_rad=0.0,
    wp_speed_up_m_s=0.0,
    wp_speed_down_m_s=0.0,
    wp_accel_z_m_s2=0.0,
)
"""A vehicle that may do nothing, so that every required limit is seen."""


def around(radius_m: float, speed_m_s: float) -> Track:
    """Many laps of a circle, ten fixes a second."""
    return circle(radius_m, speed_m_s, laps=4, rate_hz=10.0)


def climbing(up_m_s: Floats, rate_hz: float = 10.0) -> Track:
    """A straight flight at 3 m/s with recorded velocities, climbing as asked."""
    time_s = np.arange(len(up_m_s)) / rate_hz
    track = track_through(np.column_stack([3.0 * time_s, 0.0 * time_s]), time_s)
    return replace(track, north_m_s=np.full(len(time_s), 3.0), east_m_s=0.0 * time_s, up_m_s=up_m_s)


def test_a_circle_needs_its_speed_and_its_acceleration() -> None:
    """At 6 m/s around 12 m: 3 m/s² across, of which spline legs get half, with a fifth of headroom."""
    limits = required_limits(around(12.0, 6.0), NONE)
    assert limits["wp_speed_m_s"] == pytest.approx(1.2 * 6.0, rel=0.02)
    assert limits["wp_accel_m_s2"] == pytest.approx(1.2 * 3.0 / 0.5, rel=0.03)
    assert limits["wp_jerk_m_s3"] == limits["wp_accel_m_s2"]
    assert limits["shaping_jerk_m_s3"] == pytest.approx(2.0 * limits["wp_accel_m_s2"])
    lean = atan((1.2 * 3.0 + 0.35 * 6.0) / GRAVITY_M_S2)
    assert limits["lean_angle_rad"] == pytest.approx(lean, rel=0.02)


def test_limits_have_upper_bounds() -> None:
    """However fast the recording: 20 m/s², a jerk of 20 m/s³ and a lean of 45 degrees."""
    limits = required_limits(around(8.0, 12.0), NONE)
    assert limits["wp_accel_m_s2"] == limits["shaping_jerk_m_s3"] == 20.0
    assert limits["lean_angle_rad"] == pi / 4


def test_only_what_must_be_raised_is_returned() -> None:
    """Nothing for a slow flight; for a fast one what it exceeds, and nothing is lowered."""
    assert required_limits(along([(0, 0), (100, 0)], 3.0), Limits()) == {}
    assert list(required_limits(along([(0, 0), (900, 0)], 15.0), Limits())) == ["wp_speed_m_s"]
    fast = required_limits(sped_up(circle(20.0, 3.0, laps=2), 3.16), Limits())
    assert {"wp_accel_m_s2", "wp_jerk_m_s3", "lean_angle_rad"} <= fast.keys()


def test_climbs_and_descents_need_their_own_speeds() -> None:
    """Recorded velocities tell 4 m/s up and 3 m/s down, and how fast the one becomes the other."""
    up_m_s = np.concatenate([np.full(100, 4.0), np.linspace(4.0, -3.0, 40), np.full(100, -3.0)])
    limits = required_limits(climbing(up_m_s), NONE)
    assert limits["wp_speed_up_m_s"] == pytest.approx(1.2 * 4.0)
    assert limits["wp_speed_down_m_s"] == pytest.approx(1.2 * 3.0)
    assert limits["wp_accel_z_m_s2"] == pytest.approx(1.2 * 7.0 / 3.9, rel=0.02)


def test_recorded_velocities_count_more_than_positions() -> None:
    """Where a log has them; where one is missing, positions tell all."""
    track = climbing(np.zeros(100))
    told = replace(track, north_m_s=np.full(100, 8.0))
    assert required_limits(told, NONE)["wp_speed_m_s"] == pytest.approx(1.2 * 8.0)
    told.north_m_s[50] = np.nan
    assert required_limits(told, NONE)["wp_speed_m_s"] == pytest.approx(1.2 * 3.0, rel=0.001)


def test_an_unknown_climb_rate_is_none() -> None:
    """A log without vertical velocities asks for no climb."""
    limits = required_limits(climbing(np.full(100, np.nan)), NONE)
    assert not {"wp_speed_up_m_s", "wp_speed_down_m_s", "wp_accel_z_m_s2"} & limits.keys()


def test_single_outliers_set_no_limit() -> None:
    """One second in two hundred at 15 m/s is above the 99th percentile; four are not."""
    speeds = np.full(2000, 4.0)
    speeds[1000:1010] = 15.0
    outlier = replace(climbing(np.zeros(2000)), north_m_s=speeds)
    assert required_limits(outlier, NONE)["wp_speed_m_s"] == pytest.approx(1.2 * 4.0, rel=0.01)
    speeds[1000:1040] = 15.0
    assert required_limits(replace(outlier, north_m_s=speeds), NONE)["wp_speed_m_s"] > 12.0


@pytest.mark.parametrize("rate_hz", [4.0, 10.0, 50.0])
def test_velocities_are_averaged_over_a_second(rate_hz: float) -> None:
    """A wave of one second counts little, one of ten seconds nearly whole, at any rate of fixes."""
    time_s = np.arange(0.0, 60.0, 1 / rate_hz)
    quick, slow = (np.sin(2 * np.pi * time_s / period_s) for period_s in (1.0, 10.0))
    assert required_limits(climbing(quick, rate_hz), NONE)["wp_speed_up_m_s"] < 0.3
    assert required_limits(climbing(slow, rate_hz), NONE)["wp_speed_up_m_s"] > 1.2 * 0.97


def test_the_first_and_last_fixes_count_as_their_neighbours_do() -> None:
    """A flight at constant speed has no acceleration, at its ends neither."""
    limits = required_limits(climbing(np.full(12, 2.0)), NONE)
    assert limits["wp_speed_up_m_s"] == pytest.approx(2.4)
    assert "wp_accel_z_m_s2" not in limits
    assert limits["wp_speed_m_s"] == pytest.approx(3.6)
    assert limits.get("wp_accel_m_s2", 0.0) == pytest.approx(0.0, abs=1e-9)


def test_what_was_not_flown_needs_nothing() -> None:
    """A car ride to the field at 20 m/s, disarmed, raises no limit."""
    ride = along([(0, 0), (400, 0)], 20.0)
    ride = replace(ride, armed=np.full(len(ride), Armed.NO, np.int8))
    flight = along([(400, 0), (460, 0)], 3.0)
    flight = replace(flight, time_s=flight.time_s + 30.0)
    assert required_limits(joined(ride, flight), Limits()) == {}


@pytest.mark.parametrize("fixes", [1, 2])
def test_a_few_fixes_tell_no_acceleration(fixes: int) -> None:
    """Of one fix nothing is known, of two the recorded speed."""
    track = climbing(np.full(20, 2.0)).select(slice(0, fixes))
    limits = required_limits(track, NONE)
    assert limits["wp_speed_up_m_s"] == pytest.approx(2.4)
    assert not {"wp_accel_m_s2", "wp_accel_z_m_s2"} & limits.keys()


def test_fixes_at_one_time_are_a_millisecond_apart() -> None:
    """A clock that stands still gives large rates, not infinite ones."""
    track = replace(climbing(np.zeros(40)), time_s=np.zeros(40), north_m_s=np.full(40, np.nan))
    assert all(np.isfinite(value) for value in required_limits(track, NONE).values())

"""The target waits for a copter that falls behind."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_replay.simulator.dynamics.aerodynamics import Air
from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.position_control import PositionControl
from flight_replay.simulator.navigation.track_scaler import TrackScaler, mean_clamped
from flight_replay.simulator.navigation.waypoint_navigation import WaypointNavigation


def scale_after(seconds: float, *, behind_m: float, made_good_m_s: float) -> float:
    """The time scale after the target has flown at 5 m/s for some seconds."""
    limits = Limits()
    airframe = Airframe(limits, (0.0, 0.0, 20.0), 0.0, Air(), 0.02)
    control = PositionControl(limits, airframe)
    control.vn, control.n = 5.0, behind_m
    airframe.vn = made_good_m_s
    scaler = TrackScaler()
    for _ in range(round(seconds / 0.02)):
        scaler.advance(limits, control, airframe)
    return scaler.scale


def test_a_copter_that_keeps_up_does_not_slow_the_target() -> None:
    """At the target's own speed and position, the time scale is 1."""
    assert scale_after(10.0, behind_m=0.0, made_good_m_s=5.0) == 1.0


def test_five_percent_of_lag_is_allowed() -> None:
    """The time scale follows the share of speed that is made good plus five percent, within seconds."""
    assert scale_after(20.0, behind_m=0.0, made_good_m_s=4.0) == pytest.approx(0.85, abs=0.001)
    assert scale_after(2.5, behind_m=0.0, made_good_m_s=4.0) == pytest.approx(0.85 + 0.15 / 2.718, abs=0.001)


def test_distance_counts_as_lag_and_stops_the_target() -> None:
    """Far behind, the target waits."""
    assert scale_after(30.0, behind_m=6.0, made_good_m_s=0.0) == pytest.approx(0.0, abs=0.001)


def test_only_the_distance_that_is_corrected_counts() -> None:
    """3 m behind a target of 0.5 m/s, but on the way to it at 1.6: as seen from half a metre, it keeps up."""
    limits = Limits()
    airframe = Airframe(limits, (0.0, 0.0, 20.0), 0.0, Air(), 0.0025)
    navigation = WaypointNavigation(limits, airframe, PositionControl(limits, airframe))
    navigation.set_speed(0.5)
    navigation.set_wp_destination((50.0, 0.0, 20.0))
    for _ in range(4000):
        navigation.advance()
    airframe.n, airframe.vn = airframe.n - 3.0, 1.6
    before = navigation.track_scaler.scale
    navigation.advance()
    assert navigation.track_scaler.scale >= before


@given(st.floats(-3, 3), st.floats(0.0, 5.0))
def test_a_noisy_value_averages_within_its_bounds(mean: float, deviation: float) -> None:
    """The mean of a clamped value lies within 0 and 1, and at a half where the value does."""
    value = mean_clamped(mean, deviation)
    assert 0.0 <= value <= 1.0
    assert mean_clamped(0.5, deviation) == pytest.approx(0.5)
    assert mean_clamped(1.0 - mean, deviation) == pytest.approx(1.0 - value, abs=1e-9)


def test_the_last_bits_of_a_mean_are_not_kept() -> None:
    """C libraries differ in those of erf, which would decide how legs from rest begin."""
    values = [mean_clamped(mean, 63.0) for mean in (-30.7, -1.1, 0.3, 2.9)]
    assert all((value * 2**30).is_integer() and value > 0.3 for value in values)


def scale_after_rest(climb_m_s: float, *moves: tuple[float, float]) -> float:
    """The time scale a second after a target came to rest that moved up and north so fast, a second each.

    ``climb_m_s`` is how fast the copter climbed when that began.
    """
    limits = Limits()
    airframe = Airframe(limits, (0.0, 0.0, 20.0), 0.0, Air(), 0.02)
    control = PositionControl(limits, airframe)
    scaler = TrackScaler(climb_m_s)
    for up, north in (*moves, (0.0, 0.0)):
        control.vu = airframe.vu = up
        control.vn = airframe.vn = north
        for _ in range(50):
            scaler.advance(limits, control, airframe)
    return scaler.scale


def test_a_mission_that_begins_in_a_climb_begins_slowly() -> None:
    """A second after that climb, flights of 4.6 began with 0.8; a climb of centimetres is none."""
    assert scale_after_rest(1.2, (0.2, 0.0)) == pytest.approx(0.84, abs=0.05)
    assert scale_after_rest(0.1, (0.1, 0.0)) > 0.99


def test_climbs_and_descents_of_a_mission_are_stops_like_others() -> None:
    """Eight legs of 4.6 after stops at the end of climbs and descents began as from any other stop."""
    assert scale_after_rest(0.0, (2.0, 0.0)) == 1.0
    assert scale_after_rest(0.0, (-1.5, 0.0)) == 1.0
    assert scale_after_rest(1.2, (0.2, 0.0), (0.0, 5.0), (2.0, 0.0)) > 0.95

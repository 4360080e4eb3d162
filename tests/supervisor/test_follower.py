"""The reference's clock beside the vehicle's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.reference_motion import motion_through
from flight_replay.supervisor.follower import Follower, Learned, Tuning
from tests.helpers.supervised import s_curve

NO_LEADS = Tuning(0.0, 0.0, 0.0, 0.0, braking_m_s2=0.0, braking_ahead_m=0.0, braking_slower_m_s=0.0)
BRAKING = replace(NO_LEADS, braking_m_s2=2.0, braking_ahead_m=1.5, braking_slower_m_s=0.5)


def _follower(until_s: float) -> Follower:
    """A follower that has sent targets up to a recording's time; vehicle time is 100 s later."""
    follower = Follower(s_curve(), 3.0, NO_LEADS)
    for time_s in np.arange(95.0, 100.0 + until_s + 1e-6, 0.1):
        follower.target(float(time_s))
    return follower


def test_targets_are_the_reference_in_step() -> None:
    follower = _follower(20.0)
    target, state = follower.target(120.1), s_curve().state(20.1)
    assert follower.recording_s == pytest.approx(20.1)
    assert target.position_m == pytest.approx(state.position_m, abs=1e-6)
    assert target.velocity_m_s == pytest.approx(state.velocity_m_s, abs=1e-6)
    assert target.acceleration_m_s2 == pytest.approx(state.acceleration_m_s2, abs=1e-6)
    assert target.heading_deg == pytest.approx(0.0)


def test_leads_are_taken_of_each_quantity() -> None:
    follower = Follower(s_curve(), 3.0, replace(NO_LEADS, position_s=0.1, velocity_s=0.2, acceleration_s=0.3))
    follower.target(95.0)
    for time_s in np.arange(95.1, 115.05, 0.1):
        target = follower.target(float(time_s))
    assert target.position_m == pytest.approx(s_curve().state(15.1).position_m, abs=1e-6)
    assert target.velocity_m_s == pytest.approx(s_curve().state(15.2).velocity_m_s, abs=1e-6)
    assert target.acceleration_m_s2 == pytest.approx(s_curve().state(15.3).acceleration_m_s2, abs=1e-6)


def test_a_target_brakes_until_the_next_one_comes_and_is_ahead_to_make_up_for_it() -> None:
    """What ArduCopter's corrections make of distance and velocity is what the acceleration lacks."""
    follower = Follower(s_curve(), 3.0, BRAKING)
    for time_s in np.arange(95.0, 115.05, 0.1):
        target = follower.target(float(time_s))
    state = s_curve().state(15.0)
    ahead_m = target.position_m - state.position_m
    faster_m_s = target.velocity_m_s - state.velocity_m_s
    lacks_m_s2 = state.acceleration_m_s2 - target.acceleration_m_s2
    assert np.linalg.norm(lacks_m_s2) == pytest.approx(2.0)
    assert lacks_m_s2 @ state.velocity_m_s > 0.9 * 2.0 * np.linalg.norm(state.velocity_m_s)
    mean_until_the_next_m_s = faster_m_s - 0.05 * lacks_m_s2
    assert 2.0 * ahead_m + 2.0 * mean_until_the_next_m_s == pytest.approx(lacks_m_s2, abs=1e-6)


def test_a_target_does_not_brake_where_the_clock_stands() -> None:
    follower = Follower(s_curve(), 3.0, BRAKING)
    for time_s in np.arange(95.0, 139.05, 0.1):
        follower.target(float(time_s))
    place_m = s_curve().state(20.0).position_m
    follower.resume(150.0, place_m, np.zeros(3))
    assert follower.target(150.0).position_m == pytest.approx(place_m, abs=1e-6)


def test_waits_for_a_vehicle_that_falls_behind_and_goes_on_when_it_is_back() -> None:
    follower = _follower(20.0)
    aside_m = s_curve().state(20.0).position_m + np.array([0.0, 4.0, 0.0])
    follower.observe(120.0, aside_m, np.zeros(3))
    assert follower.error_m == pytest.approx(4.0, abs=0.01)
    for step in range(1, 60):
        follower.target(120.0 + 0.1 * step)
    assert follower.rate == 0.0
    waited_s = follower.recording_s
    follower.observe(125.9, s_curve().state(waited_s).position_m, np.zeros(3))
    for step in range(60, 120):
        follower.target(120.0 + 0.1 * step)
    assert follower.rate == 1.0
    assert follower.recording_s > waited_s + 2.0


def test_its_clock_changes_gently() -> None:
    follower = _follower(20.0)
    follower.observe(120.0, s_curve().state(20.0).position_m + np.array([0.0, 4.0, 0.0]), np.zeros(3))
    rates = []
    for step in range(1, 60):
        follower.target(120.0 + 0.1 * step)
        rates.append(follower.rate)
    assert np.abs(np.diff([1.0, *rates])).max() <= 0.03 + 1e-9


def test_after_a_gap_it_goes_on_where_the_vehicle_is() -> None:
    follower = _follower(20.0)
    late = s_curve().state(21.2)
    follower.resume(123.0, late.position_m, late.velocity_m_s)
    target = follower.target(123.0)
    assert follower.recording_s == pytest.approx(21.2, abs=0.1)
    assert follower.rate == pytest.approx(1.0, abs=0.1)
    assert target.position_m == pytest.approx(late.position_m, abs=0.05)


def test_after_a_gap_a_vehicle_at_rest_is_fetched_at_walking_speed() -> None:
    follower = _follower(20.0)
    aside_m = s_curve().state(20.5).position_m + np.array([3.0, -4.0, 0.0])
    follower.resume(130.0, aside_m, np.zeros(3))
    targets = [follower.target(130.0 + 0.1 * step) for step in range(80)]
    places = np.array([target.position_m for target in targets])
    assert places[0] == pytest.approx(aside_m, abs=1e-6)
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() <= 0.1 * (2.0 + 2.5)
    assert follower.offset_m < 0.01


def test_after_a_gap_the_reference_runs_slowly_until_the_vehicle_has_settled() -> None:
    follower = _follower(15.0)
    on_path = s_curve().state(16.0)
    follower.resume(116.0, on_path.position_m, on_path.velocity_m_s)
    rates = []
    for step in range(120):
        follower.target(116.0 + 0.1 * step)
        rates.append(follower.rate)
    assert rates[0] == pytest.approx(1.0, abs=0.1)
    assert rates[39] == pytest.approx(0.6, abs=0.05)
    assert rates[-1] == 1.0
    assert np.abs(np.diff(rates)).max() <= 0.03 + 1e-9


def test_a_path_that_turns_back_is_rejoined_in_the_direction_of_flight() -> None:
    follower = _follower(18.0)
    forward = s_curve().state(19.0)
    follower.resume(119.5, forward.position_m, forward.velocity_m_s)
    assert follower.recording_s == pytest.approx(19.0, abs=0.1)
    follower.resume(121.0, forward.position_m, -forward.velocity_m_s)
    assert follower.rate == 0.0


def test_far_off_it_begins_anew_from_the_vehicle() -> None:
    follower = _follower(20.0)
    follower.observe(120.0, s_curve().state(20.0).position_m + np.array([0.0, 7.0, 0.0]), np.zeros(3))
    assert follower.offset_m > 5.0
    assert follower.error_m == pytest.approx(7.0, abs=0.01)


def test_the_recordings_time_is_known_between_two_targets() -> None:
    follower = Follower(s_curve(), max_error_m=3.0)
    assert follower.recording_at_s(50.0) == -5.0
    for time_s in (50.0, 50.1, 50.2):
        follower.target(time_s)
    assert follower.recording_at_s(50.15) == pytest.approx(-4.85)


def test_the_recordings_time_runs_on_where_the_next_target_is_late() -> None:
    follower = Follower(s_curve(), max_error_m=3.0)
    follower.target(50.0)
    assert follower.recording_at_s(50.3) == pytest.approx(-4.7)


def test_a_vehicle_that_is_always_late_gets_its_targets_earlier() -> None:
    """What a link or an airframe adds to the leads of the firmware is learned, without moving the clock."""
    follower, reference, late_s = Follower(s_curve(), 3.0, NO_LEADS), s_curve(), 0.08
    ahead_s = 0.0
    for time_s in np.arange(95.0, 100.0 + reference.end_s - 1.0, 0.1):
        target = follower.target(float(time_s))
        state = reference.state(follower.recording_s + ahead_s - late_s)
        follower.observe(float(time_s), state.position_m, state.velocity_m_s)
        ahead_s = follower.learned_lead_s
    assert ahead_s == pytest.approx(late_s, abs=0.02)
    assert follower.recording_s == pytest.approx(time_s - 100.0)
    assert target.position_m == pytest.approx(
        reference.state(follower.recording_s + ahead_s).position_m, abs=0.01
    )


def test_a_vehicle_with_more_drag_gets_its_targets_displaced() -> None:
    """The share of the lag that it has, beside what the leads make up for, is learned where it is behind."""
    times_s = np.linspace(-5.0, 45.0, 400)
    waves_m = np.column_stack([0.5 * np.sin(times_s), 0.5 * np.cos(times_s), 0.0 * times_s])
    lag = motion_through(times_s, waves_m)
    follower = Follower(replace(s_curve(), drag_lag=lag), 3.0, NO_LEADS)
    learned = follower.learned.drag
    assert learned.value == pytest.approx(0.3)
    for time_s in np.arange(95.0, 100.0 + s_curve().end_s - 1.0, 0.1):
        follower.target(float(time_s))
        state = s_curve().state(follower.recording_s)
        off_m = (learned.value - 1.2) * lag.state(follower.recording_s).position_m
        follower.observe(float(time_s), state.position_m + off_m, state.velocity_m_s)
    assert learned.value == pytest.approx(1.2, abs=0.1)
    assert len(follower.misses) > 400


def test_a_vehicle_that_stands_gets_targets_where_it_is() -> None:
    """What makes up for drag, or for what passes missed, is for the way at its speed."""
    times_s = np.linspace(-5.0, 45.0, 400)
    metre = motion_through(times_s, np.tile([1.0, 0.0, 0.0], (400, 1)))
    learned = replace(Learned.nothing(), displacement=metre)
    lags = replace(s_curve(), drag_lag=metre, acceleration_lag=metre)
    follower = Follower(lags, 3.0, NO_LEADS, learned)
    moving = follower.target(100.0)
    assert moving.position_m - s_curve().state(follower.recording_s).position_m == pytest.approx([2.3, 0, 0])
    place_m = s_curve().state(10.0).position_m + np.array([0.0, 2.0, 0.0])
    follower.resume(125.0, place_m, np.zeros(3))
    assert follower.target(125.0).position_m == pytest.approx(place_m, abs=0.1)

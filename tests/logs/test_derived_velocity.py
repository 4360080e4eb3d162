"""Velocities from positions."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.logs.derived_velocity import with_derived_velocity
from flight_replay.logs.flights import find_flights
from flight_replay.logs.track import Track, track_from_columns
from tests.helpers.made_tracks import FRAME, straight_track


def walk(time_s: np.ndarray, north_m: np.ndarray) -> Track:
    """A flight north without velocities."""
    lat, lon = FRAME.to_degrees(np.column_stack([north_m, np.zeros(len(north_m))]))
    return track_from_columns(time_s, lat, lon, np.zeros(len(time_s)))


@pytest.mark.parametrize("rate_hz", [0.2, 1.0, 8.0, 50.0])
def test_a_steady_speed_is_found_at_any_rate(rate_hz: float) -> None:
    """At the ends too."""
    time_s = np.arange(0, 100, 1 / rate_hz)
    assert with_derived_velocity(walk(time_s, 4.0 * time_s)).north_m_s == pytest.approx(4.0, abs=1e-3)


def test_a_receiver_at_rest_does_not_fly() -> None:
    """One metre of slow wander, noise of 10 cm once a second."""
    time_s = np.arange(600.0)
    noise_m = np.random.default_rng(1).normal(0, 0.1, 600) + np.sin(time_s / 60)
    assert find_flights(with_derived_velocity(walk(time_s, noise_m))) == ()


def test_recorded_velocities_stay_and_unknown_ones_are_filled() -> None:
    """Fix by fix."""
    track = straight_track()
    north = np.full(len(track), 3.0)
    north[10] = np.nan
    filled = with_derived_velocity(replace(track, north_m_s=north))
    assert filled.north_m_s[9:12] == pytest.approx([3.0, 4.0, 3.0], abs=1e-3)


def test_nothing_moves_over_gaps_boots_or_at_a_single_fix() -> None:
    """What was between is not known."""
    time_s = np.array([0.0, 1.0, 20.0, 21.0, 22.0])
    track = walk(time_s, np.array([0.0, 0.0, 500.0, 500.0, 900.0]))
    track = replace(track, boot=np.array([0, 0, 0, 0, 1], np.int32))
    assert with_derived_velocity(track).north_m_s.tolist() == pytest.approx([0.0] * 5)


def test_without_times_there_is_no_velocity() -> None:
    """Nor is one made up."""
    assert np.isnan(with_derived_velocity(replace(straight_track(), timed=False)).north_m_s).all()

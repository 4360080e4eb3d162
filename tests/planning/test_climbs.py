"""Heights that a vehicle can have in time: near the recorded ones, within its limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.climbs import feasible_heights_m
from flight_replay.simulator.dynamics.limits import Limits

TIME_S = np.arange(0.0, 120.0, 0.5)
LIMITS = Limits()


def flown(wanted_m: Floats, speed_m_s: float = 0.0, limits: Limits = LIMITS) -> Floats:
    return feasible_heights_m(TIME_S, wanted_m, np.full(len(TIME_S), speed_m_s), limits, 5.0)


def rates_m_s(height_m: Floats) -> Floats:
    return np.asarray(np.diff(height_m) / 0.5)


def test_what_the_vehicle_can_do_is_flown_as_recorded() -> None:
    """A gentle wave stays as it is, to the last bit."""
    wanted = 20.0 + 5.0 * np.sin(TIME_S / 10.0)
    assert flown(wanted) is wanted


def test_a_sudden_climb_begins_sooner_and_ends_later_by_as_much() -> None:
    """20 m at once: half of it is climbed before, at 2.5 m/s, and the rest after."""
    wanted = np.where(TIME_S < 60.0, 20.0, 40.0)
    height = flown(wanted)
    assert np.interp(59.75, TIME_S, height) == pytest.approx(30.0, abs=0.1)
    assert height == pytest.approx(60.0 - height[::-1], abs=0.1)
    assert rates_m_s(height).max() == pytest.approx(2.5, abs=0.03)
    assert height[[0, -1]] == pytest.approx([20.0, 40.0], abs=0.1)


def test_a_descent_is_slower() -> None:
    """At 1.5 m/s, from 40 m to the floor, and never below it."""
    height = flown(np.where(TIME_S < 60.0, 40.0, 5.0))
    assert rates_m_s(height).min() == pytest.approx(-1.5, abs=0.03)
    assert height.min() >= 5.0
    assert height[-1] == pytest.approx(5.0, abs=0.1)


def test_a_vehicle_that_climbs_faster_stays_nearer() -> None:
    """The limits of the vehicle count, not the defaults."""
    wanted = np.where(TIME_S < 60.0, 10.0, 40.0)
    quick = Limits(wp_speed_up_m_s=8.0, wp_accel_z_m_s2=4.0)
    assert np.abs(flown(wanted, limits=quick) - wanted).sum() < 0.5 * np.abs(flown(wanted) - wanted).sum()


def test_who_flies_on_curves_upwards_less_than_who_stands() -> None:
    """A bump of 2 m within 8 s holds nobody up who stands, and is flattened at 6 m/s."""
    wanted = 20.0 + np.where(np.abs(TIME_S - 60.0) < 4.0, 1.0 + np.cos((TIME_S - 60.0) * np.pi / 4.0), 0.0)
    standing, flying = flown(wanted), flown(wanted, speed_m_s=6.0)
    bends = [np.abs(np.diff(rates_m_s(height)) / 0.5).max() for height in (standing, flying)]
    assert np.abs(standing - wanted).max() < 0.1
    assert bends[0] > 3.0 * bends[1]
    assert bends[1] == pytest.approx(0.2, abs=0.05)


@settings(max_examples=40, derandomize=True, deadline=None)
@given(steps=st.lists(st.floats(-20.0, 20.0), min_size=1, max_size=12))
def test_limits_are_kept_whatever_was_recorded(steps: list[float]) -> None:
    """Rates and accelerations, within a tolerance, and the floor."""
    wanted = np.maximum(20.0 + np.cumsum(steps)[np.arange(len(TIME_S)) * len(steps) // len(TIME_S)], 5.0)
    height = flown(wanted)
    rates = rates_m_s(height)
    assert -1.5 - 0.1 <= rates.min() <= rates.max() <= 2.5 + 0.1
    assert np.abs(np.diff(rates) / 0.5).max() <= 1.0 + 0.25
    assert height.min() >= 5.0


@pytest.mark.parametrize("fixes", [1, 3])
def test_a_clock_that_stands_still_changes_nothing(fixes: int) -> None:
    """Without time there is no climb rate."""
    wanted = np.linspace(5.0, 50.0, fixes)
    assert feasible_heights_m(np.full(fixes, 7.0), wanted, np.zeros(fixes), LIMITS, 5.0) is wanted


def test_long_recordings_take_coarser_steps() -> None:
    """Eleven days of fixes every ten seconds are done at once, and stay near what was recorded."""
    time_s = np.arange(0.0, 1e6, 10.0)
    wanted = 30.0 + 20.0 * np.sin(time_s / 3000.0)
    found = feasible_heights_m(time_s, wanted, np.zeros(len(time_s)), LIMITS, 5.0)
    assert np.abs(found - wanted).max() < 0.5

"""How hard targets brake until the next one comes."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from flight_replay.planning.following.braking import braking_within
from flight_replay.planning.vehicle_limits import FOLLOWING_NAMES, limits_of
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.supervisor.follower import DEFAULT_TUNING, Tuning


def _braking(accel_m_s2: float, jerk_m_s3: float) -> tuple[float, float, float]:
    limits = replace(Limits(), wp_accel_m_s2=accel_m_s2, shaping_jerk_m_s3=jerk_m_s3)
    tuning = braking_within(DEFAULT_TUNING, limits)
    return tuning.braking_m_s2, tuning.braking_ahead_m, tuning.braking_slower_m_s


def test_the_default_is_that_of_arducopters_defaults() -> None:
    tuning = braking_within(DEFAULT_TUNING, Limits())
    assert tuning.braking_m_s2 == pytest.approx(DEFAULT_TUNING.braking_m_s2)
    assert tuning.braking_ahead_m == pytest.approx(DEFAULT_TUNING.braking_ahead_m)
    assert tuning.braking_slower_m_s == pytest.approx(DEFAULT_TUNING.braking_slower_m_s)


@pytest.mark.parametrize(("accel_m_s2", "jerk_m_s3"), [(2.5, 5.0), (1.0, 5.0), (8.0, 5.0), (5.0, 10.0)])
def test_a_target_is_little_ahead_and_what_it_pulls_with_is_a_correction_that_is_made(
    accel_m_s2: float, jerk_m_s3: float
) -> None:
    braking_m_s2, ahead_m, slower_m_s = _braking(accel_m_s2, jerk_m_s3)
    gain_per_s = jerk_m_s3 / accel_m_s2
    assert ahead_m <= 1.5 + 1e-9
    assert braking_m_s2 <= 0.8 * accel_m_s2 + 1e-9
    assert braking_m_s2 == pytest.approx(ahead_m * gain_per_s**2 / 2 - slower_m_s * gain_per_s)


def test_a_firmware_whose_targets_do_not_brake_keeps_its_tuning() -> None:
    without = Tuning(braking_m_s2=0.0, braking_ahead_m=0.0, braking_slower_m_s=0.0)
    assert braking_within(without, Limits()) == without


@pytest.mark.parametrize(("accel_m_s2", "jerk_m_s3"), [(2.5, 0.0), (0.0, 5.0)])
def test_without_a_correction_there_is_no_braking(accel_m_s2: float, jerk_m_s3: float) -> None:
    assert _braking(accel_m_s2, jerk_m_s3) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("options", [16.0, 32.0])
def test_a_vehicle_that_is_not_pulled_to_targets_gets_none_that_brake(options: float) -> None:
    tuning = braking_within(DEFAULT_TUNING, replace(Limits(), guided_options=options))
    assert (tuning.braking_m_s2, tuning.braking_ahead_m) == (0.0, 0.0)


@pytest.mark.parametrize(
    "slow",
    [
        {"WPNAV_SPEED": 1000.0, "WPNAV_ACCEL": 100.0, "PSC_JERK_XY": 5.0, "ATC_ACCEL_R_MAX": 30000.0},
        {"WP_SPD": 10.0, "WP_ACC": 1.0, "PSC_NE_JERK": 5.0, "ATC_ACC_R_MAX": 300.0},
    ],
)
def test_a_vehicle_that_is_slow_to_lean_corrects_with_less_jerk(slow: dict[str, float]) -> None:
    """As AC_PosControl::set_max_speed_accel_xy has it, in the names of 4.6 and of 4.7."""
    assert set(slow) & set(FOLLOWING_NAMES)
    found = limits_of(slow, "ArduCopter")
    assert found is not None
    jerk_m_s3 = 0.5 * (1.0 * math.radians(300.0) * 9.80665) ** 0.5
    assert jerk_m_s3 < 5.0
    tuning = braking_within(DEFAULT_TUNING, found.limits)
    assert tuning.braking_m_s2 == pytest.approx(0.8)
    assert tuning.braking_ahead_m == pytest.approx(1.5 * 0.8 / (jerk_m_s3**2 / 2))

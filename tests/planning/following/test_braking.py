"""How hard targets brake until the next one comes."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flight_replay.planning.following.braking import braking_within
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.supervisor.follower import DEFAULT_TUNING, Tuning


def _braking(accel_m_s2: float, jerk_m_s3: float) -> tuple[float, float]:
    limits = replace(Limits(), wp_accel_m_s2=accel_m_s2, shaping_jerk_m_s3=jerk_m_s3)
    tuning = braking_within(DEFAULT_TUNING, limits)
    return tuning.braking_m_s2, tuning.braking_ahead_m


def test_the_default_is_that_of_arducopters_defaults() -> None:
    tuning = braking_within(DEFAULT_TUNING, Limits())
    assert tuning.braking_m_s2 == pytest.approx(DEFAULT_TUNING.braking_m_s2)
    assert tuning.braking_ahead_m == pytest.approx(DEFAULT_TUNING.braking_ahead_m)


@pytest.mark.parametrize(("accel_m_s2", "jerk_m_s3"), [(2.5, 5.0), (1.0, 5.0), (8.0, 5.0), (5.0, 10.0)])
def test_a_target_is_at_most_a_metre_ahead_and_what_it_pulls_with_is_a_correction_that_is_made(
    accel_m_s2: float, jerk_m_s3: float
) -> None:
    braking_m_s2, ahead_m = _braking(accel_m_s2, jerk_m_s3)
    assert ahead_m <= 1.0 + 1e-9
    assert braking_m_s2 <= 0.8 * accel_m_s2 + 1e-9
    assert braking_m_s2 == pytest.approx(ahead_m * (jerk_m_s3 / accel_m_s2) ** 2 / 2)


def test_a_firmware_whose_targets_do_not_brake_keeps_its_tuning() -> None:
    without = Tuning(braking_m_s2=0.0, braking_ahead_m=0.0)
    assert braking_within(without, Limits()) == without


@pytest.mark.parametrize("options", [16.0, 32.0])
def test_a_vehicle_that_is_not_pulled_to_targets_gets_none_that_brake(options: float) -> None:
    tuning = braking_within(DEFAULT_TUNING, replace(Limits(), guided_options=options))
    assert (tuning.braking_m_s2, tuning.braking_ahead_m) == (0.0, 0.0)

"""The nose turns after its target as SITL's does: late by a tenth of a second, and a little too far."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians

import pytest

from flight_replay.simulator.dynamics.heading import Heading
from flight_replay.simulator.dynamics.limits import Limits

DT = 0.02


def test_a_step_is_turned_within_the_slew_limit_and_overshoots_a_little() -> None:
    """115 degrees at 60 degrees/s take two seconds and a half."""
    heading = Heading(Limits(), 0.0, DT)
    turned = []
    for _ in range(300):
        heading.turn_towards(2.0, 0.0)
        turned.append(heading.yaw)
    assert turned[125] == pytest.approx(2.0, abs=0.1)
    assert 2.0 < max(turned) < 2.1
    assert turned[-1] == pytest.approx(2.0, abs=0.02)


@pytest.mark.parametrize("rate_deg_s", [20.0, -60.0])
def test_a_steady_turn_is_followed_some_degrees_late(rate_deg_s: float) -> None:
    """SITL's yaw is that weak: its drag is met by an error of the angle."""
    heading = Heading(Limits(), 0.0, DT)
    for _ in range(200):
        heading.turn_at(radians(rate_deg_s))
    assert degrees(heading.target - heading.yaw) % 360.0 == pytest.approx(0.06 * rate_deg_s % 360.0, abs=0.5)


def test_without_a_slew_limit_any_rate_is_taken() -> None:
    """ATC_SLEW_YAW and ATC_ACCEL_Y_MAX of 0 are none."""
    heading = Heading(replace(Limits(), yaw_slew_rad_s=0.0, yaw_accel_rad_s2=0.0), 0.0, DT)
    heading.turn_at(3.0)
    assert heading.target == pytest.approx(3.0 * DT)

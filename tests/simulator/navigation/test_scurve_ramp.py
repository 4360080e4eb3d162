"""Ramps fit their limits: what they gain and how far they go, by integration of their jerk."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from flight_replay.simulator.navigation.scurve_ramp import NO_RAMP, Kinematics, Ramp, ramp


def flown(shape: Ramp, speed: float) -> tuple[float, float, float]:
    """Speed and length after a ramp and its peak acceleration, by summing raised-cosine jerk."""
    parts = [
        (shape.rise_s, 1, 1),
        (shape.hold_jerk_s, 0, 1),
        (shape.rise_s, -1, 1),
        (shape.hold_accel_s, 0, 0),
        (shape.rise_s, 1, -1),
        (shape.hold_jerk_s, 0, -1),
        (shape.rise_s, -1, -1),
    ]
    jerk = []
    for duration, kind, sign in parts:
        s = np.linspace(0, 1, 4000, endpoint=False) + 1 / 8000
        profile = 0.5 * (1 - kind * np.cos(pi * s)) if kind else np.ones_like(s)
        jerk.append((duration / 4000, sign * shape.jerk * profile))
    dt = np.concatenate([np.full(4000, d) for d, _ in jerk])
    accel = np.cumsum(np.concatenate([j for _, j in jerk]) * dt)
    velocity = speed + np.cumsum(accel * dt)
    return float(velocity[-1]), float(np.sum(velocity * dt)), float(accel.max())


ACCEL, JERK = st.floats(0.5, 4.0), st.floats(0.5, 8.0)


@given(st.floats(0.0, 5.0), st.floats(0.5, 15.0), ACCEL, JERK, st.floats(0.5, 300.0))
def test_a_ramp_exceeds_neither_speed_nor_acceleration(
    speed: float, gain: float, accel: float, jerk: float, length: float
) -> None:
    """From any speed: the top speed and the acceleration are kept, and from rest the length too."""
    limits = Kinematics(jerk * pi / 0.6, jerk, accel)
    shape = ramp(limits, speed, speed + gain, length)
    end, gone, peak = flown(shape, speed)
    assert end <= speed + gain * (1 + 1e-3) + 1e-3
    assert peak <= accel * (1 + 1e-3)
    if speed == 0:
        assert gone <= length * (1 + 1e-3)


@given(st.floats(0.2, 20.0), ACCEL, JERK, st.floats(0.1, 500.0))
def test_from_rest_something_is_used_up(top_speed: float, accel: float, jerk: float, length: float) -> None:
    """A ramp from rest reaches the top speed, or it takes the whole length."""
    shape = ramp(Kinematics(jerk * pi / 0.6, jerk, accel), 0.0, top_speed, length)
    assume(shape.hold_jerk_s > 0 or shape.hold_accel_s > 0)
    end, gone, _ = flown(shape, 0.0)
    assert end == pytest.approx(top_speed, rel=2e-3) or gone == pytest.approx(length, rel=2e-3)


def test_nothing_to_gain_is_no_ramp() -> None:
    """At or above the top speed, or without length, the speed stays."""
    limits = Kinematics(5.0, 1.0, 2.5)
    assert ramp(limits, 5.0, 5.0, 10.0) == NO_RAMP
    assert ramp(limits, 0.0, 5.0, 0.0) == NO_RAMP


def test_a_rounding_error_of_speed_is_none() -> None:
    """A leg that is braked from and to a sum of 1e-16 m/s stops as one that is braked to 0."""
    limits = Kinematics(9.6 * pi / 0.6, 9.6, 2.5)
    assert ramp(limits, 1e-16, 4.2, 4.7) == ramp(limits, 0.0, 4.2, 4.7)

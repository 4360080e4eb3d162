"""Spline legs are Hermite curves, flown no faster than half of the acceleration allows."""

from __future__ import annotations

from math import hypot, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flight_replay.simulator.dynamics.vector import Vector, minus
from flight_replay.simulator.navigation.hermite import Ends, hermite
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.spline import Spline

LIMITS = PathLimits(10.0, 2.5, 1.5, 2.5, 1.0, 1.0, pi / 0.6)
STILL: Vector = (0.0, 0.0, 0.0)
COORDINATE = st.floats(-60.0, 60.0)
PLACE = st.tuples(COORDINATE, COORDINATE, st.floats(-5.0, 5.0))


def fly(spline: Spline, dt: float = 0.02, speed: float = 0.0) -> np.ndarray:
    """Position and velocity at each step, shape (steps, 6)."""
    rows = []
    spline.speed = speed
    while not spline.finished:
        position, velocity = spline.advance(dt)
        rows.append((*position, *velocity))
        assert len(rows) < 100_000
    return np.array(rows)


@given(PLACE, PLACE, PLACE, PLACE)
def test_the_curve_has_the_ends_and_tangents_it_is_given(a: Vector, b: Vector, m: Vector, k: Vector) -> None:
    """It runs from origin to destination; tangents are scaled to four chords together at most."""
    c = np.array(hermite(Ends(a, b, m, k)))
    assert c[0] == pytest.approx(np.array(a), abs=1e-6)
    assert c.sum(axis=0) == pytest.approx(np.array(b), abs=1e-6)
    scale = min(1.0, 4 * hypot(*minus(b, a)) / max(hypot(*m) + hypot(*k), 1e-12))
    assert c[1] == pytest.approx(scale * np.array(m), abs=1e-6)
    assert c[1] + 2 * c[2] + 3 * c[3] == pytest.approx(scale * np.array(k), abs=1e-5)


@settings(max_examples=40)
@given(PLACE, PLACE, PLACE)
def test_a_leg_arrives_within_its_limits(b: Vector, m: Vector, k: Vector) -> None:
    """From rest to its destination, never too fast, and never accelerating beyond half the limit."""
    if hypot(*b) < 1.0:
        return
    rows = fly(Spline(Ends(STILL, b, m, k), LIMITS))
    assert rows[-1, :3] == pytest.approx(np.array(b), abs=1e-6)
    speed = np.linalg.norm(rows[:, 3:], axis=1)
    assert speed.max() <= hypot(10.0, 2.5) + 1e-6
    assert np.abs(np.diff(speed[:-1])).max(initial=0.0) <= 0.5 * sqrt(2.5**2 + 1.0) * 0.02 + 1e-6


def test_the_bend_sets_the_speed() -> None:
    """On a quarter turn of about 20 m radius the speed is that of 1.25 m/s² across the track."""
    tangent = 20 * pi / 2
    spline = Spline(Ends((0, 0, 0), (20, 20, 0), (tangent, 0, 0), (0, tangent, 0)), LIMITS)
    speed = np.linalg.norm(fly(spline, speed=5.0)[:, 3:], axis=1)
    assert speed[len(speed) // 2] == pytest.approx(sqrt(1.25 * 20), rel=0.06)
    assert spline.destination_speed == pytest.approx(sqrt(1.25 * 20), rel=0.2)


def test_a_stop_is_braked_for() -> None:
    """A leg without a tangent at its end arrives almost at rest; the straight case lasts as calculated."""
    rows = fly(Spline(Ends(STILL, (40.0, 0.0, 0.0), STILL, STILL), LIMITS), dt=0.0025)
    assert np.linalg.norm(rows[-2, 3:]) < 0.3
    assert np.linalg.norm(rows[-1, 3:]) == 0.0
    assert 0.0025 * len(rows) == pytest.approx(2 * sqrt(40 / 1.25), rel=0.03)


def on_board_duration_s(length: float, speed: float, destination_speed: float) -> float:
    """Duration of a straight curve as SplineCurve::advance_target_along_track flies it, in steps of 2.5 ms.

    A step covers what the speed from before it does; the next speed is that of where the step began.
    """
    dt, accel, position, steps = 0.0025, 1.25, 0.0, 0
    while position < length:
        allowed = min(10.0, sqrt(2 * accel * (length - position) + destination_speed**2))
        position += speed * dt
        speed = min(max(allowed, speed - accel * dt), speed + accel * dt)
        steps += 1
    return steps * dt - (position - length) / speed


@pytest.mark.parametrize(
    ("length", "speed", "destination_speed"),
    [(40.0, 5.0, 0.2), (40.0, 8.0, 0.05), (100.0, 0.0, 9.9), (5.0, 0.0, 3.5)],
    ids=["almost to rest", "from 8 m/s", "from rest", "short, from rest"],
)
def test_a_leg_lasts_as_long_as_on_board(length: float, speed: float, destination_speed: float) -> None:
    """Steps of 20 ms take as long as the 2.5 ms steps of the autopilot, within a millisecond."""
    chord = (length, 0.0, 0.0)
    spline = Spline(Ends(STILL, chord, chord, chord), LIMITS)
    spline.limit_destination_speed(destination_speed)
    duration_s = 0.02 * len(fly(spline, speed=speed)) - spline.unused_s
    assert duration_s == pytest.approx(on_board_duration_s(length, speed, destination_speed), abs=0.001)


def test_the_step_does_not_change_the_motion() -> None:
    """Steps of 2.5 ms and 40 ms arrive at the same time."""
    ends = Ends(STILL, (30.0, 10.0, 5.0), STILL, (20.0, -20.0, 0.0))
    fine, coarse = (dt * len(fly(Spline(ends, LIMITS), dt)) for dt in (0.0025, 0.04))
    assert coarse == pytest.approx(fine, abs=0.05)


def test_a_leg_that_ends_within_a_step_does_not_accelerate_on() -> None:
    """The time that is left is the next leg's, with its acceleration."""
    spline = Spline(Ends(STILL, (10.0, 0.0, 0.0), (10.0, 0.0, 0.0), (10.0, 0.0, 0.0)), LIMITS)
    spline.speed = 5.0
    flown_s = 0.0
    while not spline.finished:
        spline.advance(0.3)
        flown_s += 0.3
    assert 0.05 < spline.unused_s < 0.25
    assert spline.speed == pytest.approx(5.0 + 1.25 * (flown_s - spline.unused_s), abs=0.01)


def test_a_tangent_of_centimetres_does_not_make_the_target_jump() -> None:
    """A way straight back, begun with some speed: within 0.1 m in the first step, as ArduCopter flew it."""
    spline = Spline(Ends((50.0, 0.0, 20.0), (0.0, 0.0, 20.0), (0.0, 0.0, -0.1), STILL), LIMITS)
    spline.speed = 0.3
    (north, _, _), _ = spline.advance(0.02)
    assert 49.9 < north < 50.0


def test_a_leg_without_length_is_over() -> None:
    """Coinciding ends: finished, at rest at the destination, nothing to hand over, no speed either."""
    spline = Spline(Ends((1, 2, 3), (1, 2, 3), (5, 0, 0), (5, 0, 0)), LIMITS)
    spline.speed = 3.0
    assert spline.finished
    assert spline.advance(0.02) == ((1, 2, 3), STILL)
    assert spline.speed == 0.0
    assert (spline.destination_tangent, spline.origin_speed, spline.destination_speed) == (STILL, 0.0, 0.0)


def test_a_curve_that_starts_with_jerk_only_gets_going() -> None:
    """Where tangent and second derivative vanish at the start, the third derivative leads."""
    b = (10.0, 0.0, 0.0)
    rows = fly(Spline(Ends(STILL, b, STILL, (30.0, 0.0, 0.0)), LIMITS))
    assert rows[-1, :3] == pytest.approx(np.array(b))


def test_other_limits_hold_from_the_next_step_on() -> None:
    """A changed speed is taken, and the destination's speed can be lowered but not raised."""
    spline = Spline(Ends(STILL, (80.0, 0.0, 0.0), (50.0, 0.0, 0.0), (50.0, 0.0, 0.0)), LIMITS)
    spline.change_speed(PathLimits(3.0, 2.5, 1.5, 2.5, 1.0, 1.0, 5.0))
    spline.limit_destination_speed(2.0)
    spline.limit_destination_speed(7.0)
    speed = np.linalg.norm(fly(spline)[:, 3:], axis=1)
    assert speed.max() == pytest.approx(3.0)
    assert speed[-1] == pytest.approx(2.0, abs=0.05)


def test_a_speed_too_high_to_stop_from_is_left_for_the_next_leg() -> None:
    """Entered too fast to brake, a leg ends with a speed, which then falls, though the target stays."""
    spline = Spline(Ends(STILL, (3.0, 0.0, 0.0), (3.0, 0.0, 0.0), STILL), LIMITS)
    fly(spline, speed=5.0)
    left = spline.speed
    assert left > 3.0
    position, velocity = spline.advance(0.4)
    assert position == (3.0, 0.0, 0.0)
    assert spline.speed == pytest.approx(left - 0.4 * 1.25)
    assert hypot(*velocity) == pytest.approx(spline.speed)
    spline.advance(60.0)
    assert spline.speed < 0.01


def test_time_that_nearly_stands_still_moves_nothing_back() -> None:
    """The track's time may run at a hundredth: from rest, a step of 0.2 ms is a step of no length."""
    spline = Spline(Ends((0.0, 0.0, 10.0), (20.0, 5.0, 10.0), STILL, (10.0, 10.0, 0.0)), LIMITS)
    for _ in range(50):
        (north, _, _), _ = spline.advance(0.0002)
        assert north >= 0.0
    assert np.isfinite(fly(spline)).all()

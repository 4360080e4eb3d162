"""Kinematic shaping keeps to its limits and never overshoots in one step."""

from __future__ import annotations

from math import hypot, inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_replay.simulator.dynamics.shaping import (
    kinematic_limit,
    limit_accel_xy,
    shape_position,
    shape_velocity,
    shape_velocity_xy,
    sqrt_controller,
    step_towards,
    stopping_distance,
)

POSITIVE = st.floats(0.05, 20.0)
SIGNED = st.floats(-50.0, 50.0)


@given(SIGNED, POSITIVE, POSITIVE, st.floats(0.001, 0.1))
def test_one_step_of_correction_never_passes_zero(error: float, p: float, limit: float, dt: float) -> None:
    """The correction points at zero error and covers at most all of it in one step."""
    rate = sqrt_controller(error, p, limit, dt)
    assert rate * error >= 0
    assert abs(rate) * dt <= abs(error) * (1 + 1e-9)


def test_far_from_zero_the_correction_decelerates_evenly() -> None:
    """Beyond the linear part, the rate's square grows by twice the limit per unit of error."""
    near, far = sqrt_controller(10.0, 1.0, 2.5, 0.0), sqrt_controller(30.0, 1.0, 2.5, 0.0)
    assert far**2 - near**2 == pytest.approx(2 * 2.5 * 20.0)
    assert sqrt_controller(0.5, 1.0, 2.5, 0.0) == pytest.approx(0.5)
    assert sqrt_controller(-0.5, 2.0, 0.0, 0.0) == pytest.approx(-1.0)
    assert sqrt_controller(8.0, 0.0, 1.0, 0.0) == pytest.approx(4.0)


@given(SIGNED, POSITIVE, POSITIVE)
def test_a_stop_takes_the_distance_that_allows_its_speed(speed: float, p: float, decel: float) -> None:
    """stopping_distance is the inverse of the square-root controller."""
    distance = stopping_distance(speed, p, decel)
    assert sqrt_controller(distance, p, decel, 0.0) == pytest.approx(speed, abs=1e-9)


@given(st.tuples(SIGNED, SIGNED, SIGNED), POSITIVE, POSITIVE, POSITIVE)
def test_a_direction_is_limited_by_whichever_part_is_tighter(
    way: tuple[float, float, float], level: float, up: float, down: float
) -> None:
    """The limited vector touches the horizontal or the vertical limit, and exceeds neither."""
    n, e, u = way
    length = hypot(n, e, u)
    if length < 1e-3:
        return
    most = kinematic_limit(way, level, up, down)
    flat, rise = most * hypot(n, e) / length, most * abs(u) / length
    vertical = up if u > 0 else down
    assert flat <= level * (1 + 1e-9)
    assert rise <= vertical * (1 + 1e-9)
    assert flat == pytest.approx(level) or rise == pytest.approx(vertical)


def test_no_direction_has_no_limit_to_speak_of() -> None:
    """Without a direction, or with a limit of zero, nothing is allowed."""
    assert kinematic_limit((0, 0, 0), 1, 1, 1) == 0
    assert kinematic_limit((1, 0, 0), 0, 1, 1) == 0
    assert kinematic_limit((0, 0, -2), 9, 1, 3) == 3


@given(SIGNED, SIGNED, POSITIVE)
def test_steps_are_bounded_and_arrive(target: float, value: float, step: float) -> None:
    """step_towards moves by the step at most, and exactly to a target within reach."""
    moved = step_towards(target, value, step)
    assert abs(moved - value) <= step * (1 + 1e-9)
    if abs(target - value) <= step:
        assert moved == pytest.approx(target, abs=1e-9)


def test_a_position_is_reached_within_all_limits() -> None:
    """Shaping from rest ends at rest at the goal, keeping speed, acceleration and jerk."""
    dt, goal = 0.01, 12.0
    position = speed = accel = 0.0
    for _ in range(3000):
        before = accel
        position, speed = position + speed * dt + 0.5 * accel * dt * dt, speed + accel * dt
        accel = shape_position(goal - position, speed, accel, (-1.5, 2.5, 1.0, 5.0), dt)
        assert abs(accel - before) <= 5.0 * dt * (1 + 1e-6)
        assert abs(accel) <= 1.0 + 1e-9
        assert speed <= 2.5 + 0.05
    assert position == pytest.approx(goal, abs=1e-3)
    assert speed == pytest.approx(0.0, abs=1e-3)


def test_a_velocity_error_is_met_with_the_full_acceleration_at_most() -> None:
    """A huge velocity error asks for no more than the acceleration limit, one jerk step at a time."""
    assert shape_velocity(inf, 2.99, 3.0, 5.0, 0.01) == pytest.approx(3.0)
    assert shape_velocity(-100.0, 0.0, 3.0, 5.0, 0.01) == pytest.approx(-0.05)


def test_a_horizontal_velocity_is_brought_to_rest_along_itself() -> None:
    """shape_velocity_xy brakes against the velocity, and does nothing at rest."""
    rest = (0.0, 0.0)
    north, east = shape_velocity_xy(rest, (3.0, -4.0), rest, (2.5, 5.0), 0.01)
    assert hypot(north, east) == pytest.approx(0.05)
    assert north / east == pytest.approx(-3.0 / 4.0)
    assert shape_velocity_xy(rest, rest, rest, (2.5, 5.0), 0.01) == rest


@given(SIGNED, SIGNED, SIGNED, SIGNED)
def test_a_correction_keeps_room_across_the_wanted_velocity(vn: float, ve: float, n: float, e: float) -> None:
    """The correction is within its limit; what is fed forward is not limited but in its jerk."""
    north, east = shape_velocity_xy((vn, ve), (n, e), (0.0, 0.0), (2.5, 1e6), 0.01)
    assert hypot(north, east) <= 2.5 * (1 + 1e-9)
    fed = shape_velocity_xy((vn, ve), (n, e), (0.0, 0.0), (2.5, 1e6), 0.01, feed=(7.0, 0.0))
    assert fed == pytest.approx((north + 7.0, east))
    slow = shape_velocity_xy((vn, ve), (n, e), (0.0, 0.0), (2.5, 5.0), 0.01, feed=(7.0, 0.0))
    assert hypot(*slow) <= 0.05 * (1 + 1e-9)


def test_braking_gives_way_to_a_correction_across() -> None:
    """Where most of the correction is along the velocity, half of its square at most is across."""
    north, east = shape_velocity_xy((8.0, 0.0), (0.0, 7.0), (0.0, 0.0), (2.0, 1e6), 0.01)
    assert east == pytest.approx(-(2.0**0.5))
    assert north == pytest.approx(2.0**0.5)


@given(SIGNED, SIGNED, SIGNED, SIGNED, POSITIVE)
def test_too_much_acceleration_gives_up_its_forward_part_first(
    an: float, ae: float, vn: float, ve: float, most: float
) -> None:
    """What is left is within the limit, and across the velocity as much as the limit allows."""
    speed = hypot(vn, ve)
    if 0 < speed < 1e-3:
        return
    north, east = limit_accel_xy((an, ae), (vn, ve), most)
    assert hypot(north, east) <= most * (1 + 1e-6)
    if speed > 0 and hypot(an, ae) > most:
        across = (ae * vn - an * ve) / speed
        stored_params = (east * vn - north * ve) / speed
        assert stored_params == pytest.approx(max(-most, min(most, across)), abs=1e-6)


def test_without_a_velocity_acceleration_is_just_shortened() -> None:
    """At rest there is no forward part to give up."""
    assert limit_accel_xy((3.0, 4.0), (0.0, 0.0), 2.5) == pytest.approx((1.5, 2.0))

"""Where one straight leg may begin before another has ended, by both rules that ArduCopter has had."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import pi

import pytest

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector, minus, norm
from flight_replay.simulator.navigation.leg_blending import StraightLegs, can_blend
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.scurve import SCurve

PATH_LIMITS = PathLimits(10.0, 2.5, 1.5, 2.5, 1.0, 1.0, pi / 0.6)
SLOW = PathLimits(3.0, 2.5, 1.5, 2.5, 1.0, 1.0, pi / 0.6)
OLD, LATE = Limits(), replace(Limits(), late_corners=1.0)
STEP_S = 0.0025
COLUMN = [(0.0, 0.0, 20.0), (0.0, 0.0, 40.0), (0.0, 0.0, 60.0)]


def legs(places: Sequence[Vector], path_limits: PathLimits = PATH_LIMITS) -> list[SCurve]:
    return [SCurve(minus(there, here), path_limits) for here, there in pairwise(places)]


def flown(places: Sequence[Vector], limits: Limits) -> list[tuple[Vector, float]]:
    """Target velocity and acceleration upwards, step by step, along legs that join at fast waypoints."""
    row = StraightLegs()
    todo = legs(places)
    motion: list[tuple[Vector, float]] = []
    for i, origin in enumerate(places[:-1]):
        row.begin(todo[i], previous=row.current)
        last = i == len(todo) - 1
        row.following = SCurve() if last else todo[i + 1]
        finished = False
        while not finished:
            _, velocity, accel, finished = row.advance(STEP_S, origin, None if last else limits)
            motion.append((velocity, accel[2]))
    return motion


def blend_s(places: Sequence[Vector], limits: Limits, path_limits: PathLimits = PATH_LIMITS) -> float:
    """When the second leg begins, seconds from the start of the first."""
    first, second = legs(places, path_limits)
    while not can_blend(first, second, limits):
        first.advance(STEP_S)
    return first.time


def test_a_climb_through_a_waypoint_keeps_to_the_climb_speed() -> None:
    """Both legs have 2.5 m/s; the old rule adds them up."""
    old, late = (max(norm(*velocity) for velocity, _ in flown(COLUMN, limits)) for limits in (OLD, LATE))
    assert old > 2.6
    assert late == pytest.approx(2.5, abs=0.01)


def test_a_climb_after_a_descent_keeps_to_the_vertical_acceleration() -> None:
    """Half-way through, where both legs push upwards."""
    there_and_back = [(0.0, 0.0, 60.0), (0.0, 0.0, 40.0), (0.0, 0.0, 60.0)]
    old, late = (max(accel for _, accel in flown(there_and_back, limits)) for limits in (OLD, LATE))
    assert old > 1.5
    assert late < 1.05


def test_a_corner_at_a_steady_speed_begins_when_the_vehicle_brakes() -> None:
    """Half a second later than by the old rule, by which the sum of both speeds alone counts."""
    corner = [(0.0, 0.0, 30.0), (40.0, 0.0, 30.0), (40.0, 20.0, 30.0)]
    braking_s = legs(corner, SLOW)[0].turn_out_time
    assert blend_s(corner, OLD, SLOW) < braking_s - 0.5
    assert blend_s(corner, LATE, SLOW) == pytest.approx(braking_s, abs=STEP_S)


def test_a_climb_after_a_level_leg_begins_later() -> None:
    """By the old rule as soon as the vehicle brakes, however hard both legs push upwards or ahead."""
    step = [(0.0, 0.0, 20.0), (20.0, 0.0, 20.0), (20.0, 0.0, 40.0)]
    first, second = legs(step)
    assert blend_s(step, OLD) == pytest.approx(first.turn_out_time, abs=0.1)
    assert blend_s(step, LATE) > first.turn_out_time + 1.5
    assert first.end_time - blend_s(step, LATE) <= second.gain_time


@pytest.mark.parametrize("limits", [OLD, LATE], ids=["old", "late"])
@pytest.mark.parametrize("leg_m", [3.0, 40.0])
def test_corners_of_legs_that_only_gain_and_lose_speed_are_the_same(limits: Limits, leg_m: float) -> None:
    """Level ones: there both rules come to half of the leg."""
    square = [(0.0, 0.0, 30.0), (leg_m, 0.0, 30.0), (leg_m, leg_m, 30.0)]
    assert blend_s(square, limits) == pytest.approx(blend_s(square, OLD), abs=STEP_S)

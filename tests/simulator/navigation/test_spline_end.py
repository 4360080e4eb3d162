"""What 32-bit numbers leave of a spline's motion at its end."""

from __future__ import annotations

from math import pi

import pytest

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.simulator.dynamics.vector import Vector, minus
from flight_replay.simulator.navigation.hermite import Ends
from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.spline import Spline
from flight_replay.simulator.navigation.spline_end import motion_at_rest

LIMITS = PathLimits(10.0, 2.5, 1.5, 2.5, 1.0, 1.0, pi / 0.6)
STILL: Vector = (0.0, 0.0, 0.0)


def last_leg(home: tuple[float, float], rows: list[tuple[float, float, float]], *, straight: bool) -> Ends:
    """The curve from the last but one waypoint to the last, after a straight leg or another curve."""
    frame = FlatFrame(*home)
    north_east = frame.to_metres_on_board([r[0] for r in rows], [r[1] for r in rows]).tolist()
    before, origin, destination = (
        (n, e, row[2]) for (n, e), row in zip(north_east[-3:], rows[-3:], strict=True)
    )
    origin_tangent = minus(origin, before) if straight else minus(destination, before)
    return Ends(origin, destination, origin_tangent, STILL)


@pytest.mark.parametrize(
    ("home", "rows", "straight", "direction", "speed_cm_s"),
    [
        (
            (51.03350956, -36.00201745),
            [
                (51.0335271, -36.0018061, 27.63),
                (51.0335611, -36.0016712, 27.63),
                (51.0335758, -36.0015975, 27.63),
            ],
            False,
            (0.316, -0.949, 0.0),
            0.00067,
        ),
        (
            (-31.66176758, 166.4262129),
            [
                (-31.6617367, 166.4262031, 16.0),
                (-31.6617273, 166.4261928, 16.0),
                (-31.6616707, 166.426206, 16.0),
            ],
            True,
            (-0.967, -0.256, 0.0),
            0.06176,
        ),
        (
            (19.93421184, -25.55244571),
            [
                (19.9342088, -25.5524962, 26.0),
                (19.9342095, -25.5525262, 26.0),
                (19.9341701, -25.5525567, 26.0),
            ],
            False,
            (-0.447, -0.894, 0.0),
            0.00008,
        ),
    ],
)
def test_the_target_rests_as_that_of_arducopter_did(
    home: tuple[float, float],
    rows: list[tuple[float, float, float]],
    straight: bool,
    direction: Vector,
    speed_cm_s: float,
) -> None:
    """Direction and speed are those that ArduCopter 4.6 had in SITL while it waited at a spline's end."""
    unit, speed = motion_at_rest(last_leg(home, rows, straight=straight), LIMITS)
    assert unit == pytest.approx(direction, abs=0.001)
    assert speed * 100 == pytest.approx(speed_cm_s, abs=0.00001)


def test_without_rounding_errors_it_would_fly_back() -> None:
    """A curve that ends exactly at rest on its destination leaves the way that it brakes, at no speed."""
    unit, speed = motion_at_rest(Ends(STILL, (4.0, 0.0, 0.0), (4.0, 0.0, 0.0), STILL), LIMITS)
    assert unit == (-1.0, 0.0, 0.0)
    assert speed == 0.0


def test_too_long_a_tangent_is_shortened_first() -> None:
    """An origin tangent of eight times the chord counts as one of four."""
    origin, destination = (1.37, 2.71, 20.0), (3.93, 2.71, 20.0)
    (unit, speed), (half_unit, half_speed) = (
        motion_at_rest(Ends(origin, destination, (0.0, length, 0.0), STILL), LIMITS)
        for length in (20.48, 10.24)
    )
    assert unit == pytest.approx(half_unit)
    assert speed == pytest.approx(half_speed)


def test_a_curve_to_where_it_began_has_no_direction() -> None:
    """Without length there is no motion."""
    assert motion_at_rest(Ends(STILL, STILL, STILL, STILL), LIMITS) == (STILL, 0.0)


def test_a_finished_curve_keeps_that_motion() -> None:
    """The target stays at the destination, with the velocity of rest once its speed has fallen."""
    ends = Ends((1.37, 2.71, 20.0), (31.9, -7.3, 22.2), (9.1, 4.2, 0.3), STILL)
    spline = Spline(ends, LIMITS)
    while not spline.finished:
        spline.advance(0.02)
    for _ in range(50):
        position, velocity = spline.advance(0.02)
    unit, speed = motion_at_rest(ends, LIMITS)
    assert position == ends.destination
    assert velocity == pytest.approx(tuple(speed * part for part in unit))

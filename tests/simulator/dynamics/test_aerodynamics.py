"""The air holds the airframe back as SITL's frame is held back."""

from __future__ import annotations

from math import cos, pi, sin, tan

import pytest

from flight_replay.simulator.dynamics.aerodynamics import Air, air_density_kg_m3
from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2

LEVEL, NORTH = (0.0, 0.0), (1.0, 0.0)


def test_hovering_in_still_air_stays() -> None:
    """No lean, no speed, lift equal to gravity: no acceleration."""
    assert Air().acceleration((0, 0, 0), LEVEL, NORTH, GRAVITY_M_S2) == pytest.approx((0.0, 0.0, 0.0))


def test_drag_grows_faster_than_speed_and_points_backwards() -> None:
    """Twice the speed is more than twice the drag, whatever the heading."""
    for yaw in (0.0, 1.0, pi):
        slow = Air().acceleration((3.0, 0.0, 0.0), LEVEL, (cos(yaw), sin(yaw)), GRAVITY_M_S2)
        fast = Air().acceleration((6.0, 0.0, 0.0), LEVEL, (cos(yaw), sin(yaw)), GRAVITY_M_S2)
        assert slow[0] < 0
        assert fast[0] < 2.0 * slow[0]


def test_ten_metres_per_second_need_almost_the_full_lean() -> None:
    """At the default speed SITL's copter leans 27 to 30 degrees, as recordings of it show."""
    lean = tan(28.0 / 180.0 * pi)
    north, _, _ = Air(home_amsl_m=20.0).acceleration((10.0, 0.0, 0.0), (lean, 0.0), NORTH, GRAVITY_M_S2)
    assert north == pytest.approx(0.0, abs=0.4)


def test_wind_is_the_speed_of_the_air() -> None:
    """Moving with the wind is standing in still air; standing in wind is being pushed along it."""
    wind = Air((5.0, -2.0, 0.0))
    assert wind.acceleration((5.0, -2.0, 0.0), LEVEL, (cos(0.3), sin(0.3)), GRAVITY_M_S2) == pytest.approx(
        (0.0, 0.0, 0.0)
    )
    north, east, _ = wind.acceleration((0.0, 0.0, 0.0), LEVEL, (cos(0.3), sin(0.3)), GRAVITY_M_S2)
    assert north > 0 > east


def test_square_drag_is_weaker_askew() -> None:
    """A body's drag is square along each axis, so that flying at 45 degrees to its nose is easier."""
    straight = Air().acceleration((8.0, 0.0, 0.0), LEVEL, NORTH, GRAVITY_M_S2)
    askew = Air().acceleration((8.0, 0.0, 0.0), LEVEL, (cos(pi / 4), sin(pi / 4)), GRAVITY_M_S2)
    assert askew[0] == pytest.approx(straight[0], rel=0.3)
    assert askew[1] == pytest.approx(0.0, abs=2.0)


def test_climbing_lessens_the_thrust() -> None:
    """Air coming from above takes more vertical acceleration than drag alone."""
    climb = Air().acceleration((0.0, 0.0, 5.0), LEVEL, NORTH, GRAVITY_M_S2)[2]
    sink = Air().acceleration((0.0, 0.0, -5.0), LEVEL, NORTH, GRAVITY_M_S2)[2]
    assert climb < 0 < sink
    assert -climb > sink


def test_thin_air_holds_back_less() -> None:
    """Density falls with altitude, and drag with it."""
    assert air_density_kg_m3(0.0) == pytest.approx(1.225)
    assert air_density_kg_m3(2000.0) == pytest.approx(1.007, abs=0.002)
    airs = Air(), Air(home_amsl_m=2500.0)
    low, high = (air.acceleration((9, 0, 0), LEVEL, NORTH, GRAVITY_M_S2)[0] for air in airs)
    assert low < high < 0

"""ArduPilot's metres are near ground metres, and its degrees come back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.geodesy import LocalFrame


@given(st.floats(-80, 80), st.floats(-180, 180), st.floats(-3000, 3000), st.floats(-3000, 3000))
def test_metres_and_degrees_are_inverse(lat: float, lon: float, north: float, east: float) -> None:
    """Metres to degrees and back is the same place, across the antimeridian too."""
    frame = FlatFrame(lat, lon)
    there = frame.to_degrees((north, east))
    assert frame.to_metres(*there) == pytest.approx(np.array([north, east]), abs=1e-6)
    assert -180.0 <= there[1] <= 180.0


@pytest.mark.parametrize("lat", [-60.0, -35.0, 0.0, 47.0, 64.0])
def test_they_differ_from_ground_metres_by_less_than_a_percent(lat: float) -> None:
    """A sphere's metres are within 0.7 % of the ellipsoid's, and not the same."""
    flat = FlatFrame(lat, 8.0).to_degrees((1000.0, 1000.0))
    ground = LocalFrame(lat, 8.0).to_metres(*flat)
    assert ground == pytest.approx(np.array([1000.0, 1000.0]), rel=0.007)
    assert np.abs(ground - 1000.0).max() > 0.1


def test_a_minute_of_latitude_is_ardupilots() -> None:
    """0.011131884502145034 m per 1e-7 degree."""
    assert FlatFrame(10.0, 20.0).to_metres(10.0000001, 20.0)[0] == pytest.approx(0.0111318845, rel=1e-6)


@given(st.floats(-80, 80), st.floats(-180, 180), st.floats(-3000, 3000), st.floats(-3000, 3000))
def test_on_board_metres_are_rounded_ones(lat: float, lon: float, north: float, east: float) -> None:
    """Rounded degrees and 32-bit sums change a place by centimetres, across the antimeridian too."""
    frame = FlatFrame(lat, lon)
    there = frame.to_degrees((north, east))
    assert frame.to_metres_on_board(*there) == pytest.approx(np.array([north, east]), abs=0.06)


def test_on_board_metres_are_those_of_arducopter() -> None:
    """Where ArduCopter 4.6 stopped in SITL, in its centimetres, with the home as cut off there."""
    place = FlatFrame(25.25057007, -147.02306109).to_metres_on_board(25.2509440, -147.0230166)
    assert place * 100 == pytest.approx(np.array([4163.32568, 448.03638]), abs=1e-3)


def test_on_board_metres_end_in_the_same_bit() -> None:
    """Where cosf does not give the nearest number; ArduCopter 4.6 in SITL rested by this bit."""
    place = FlatFrame(-54.8019, -68.303).to_metres_on_board(-54.80189066, -68.30306296)
    assert place * 100 == pytest.approx(np.array([103.526527, -404.238098145]), rel=0, abs=1e-5)


@pytest.mark.parametrize("lat", [0.0, 20.0, -44.9, 45.1, -70.0])
def test_the_cosine_on_board_is_exact_in_32_bits(lat: float) -> None:
    """A degree of longitude is as long on board as in double precision, to the last bits."""
    frame = FlatFrame(lat, 8.0)
    assert frame.to_metres_on_board(lat, 9.0)[1] == pytest.approx(frame.to_metres(lat, 9.0)[1], rel=4e-7)


def test_next_to_a_pole_a_degree_of_longitude_keeps_a_hundredth_of_its_length() -> None:
    """ArduPilot divides by that scale."""
    frame = FlatFrame(89.9, 0.0)
    for metres in (frame.to_metres(89.9, 1.0), frame.to_metres_on_board(89.9, 1.0)):
        assert metres[1] == pytest.approx(1113.18845, rel=1e-6)


def test_many_places_on_board_are_those_of_each() -> None:
    """Shape (n, 2), across the antimeridian to the last unit of 1e-7 degree."""
    frame = FlatFrame(0.0, 179.99999)
    lat, lon = [0.0, 0.0, 1e-5], [179.99999, -179.99999, 180.0]
    metres = frame.to_metres_on_board(lat, lon)
    assert metres == pytest.approx(np.array([[0, 0], [0, 2.2263769], [1.1131884, 1.1131884]]), abs=1e-5)

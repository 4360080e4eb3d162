"""Fences of polygons and circles: which places they forbid, and how they are read from a vehicle."""

from __future__ import annotations

import math
import tracemalloc
from dataclasses import replace
from time import process_time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flight_replay.exceptions import MissionError, VehicleError
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.mission.fence import FenceArea, areas_from_items
from flight_replay.mission.items import Mission, MissionItem, waypoint
from flight_replay.vehicle.preflight import check
from tests.vehicle.test_preflight import COPTER, HERE

FRAME = LocalFrame(47.0, 8.0)


def corner(north_m: float, east_m: float) -> tuple[float, float]:
    """A place so far from 47, 8."""
    lat, lon = FRAME.to_degrees([north_m, east_m])
    return float(lat), float(lon)


L_SHAPE = tuple(
    corner(*place) for place in [(-20, -20), (100, -20), (100, 20), (20, 20), (20, 100), (-20, 100)]
)


def polygon(stay_inside: bool = True) -> FenceArea:
    return FenceArea(L_SHAPE, None, stay_inside)


PLACES = np.array([(0.0, 0.0), (90.0, 0.0), (0.0, 90.0), (90.0, 90.0), (-30.0, 0.0)])


def test_a_polygon_keeps_in_or_out() -> None:
    """Inside an L is inside; its missing quarter is not."""
    assert polygon().forbids_legs(PLACES, PLACES, FRAME).tolist() == [False, False, False, True, True]
    assert polygon(False).forbids_legs(PLACES, PLACES, FRAME).tolist() == [True, True, True, False, False]


def test_a_circle_keeps_in_or_out() -> None:
    """By ground distance from its centre."""
    circle = FenceArea((corner(0, 0),), 50.0, True)
    assert circle.forbids_legs(PLACES, PLACES, FRAME).tolist() == [False, True, True, True, False]
    assert replace(circle, stay_inside=False).forbids_legs(PLACES, PLACES, FRAME).tolist() == [
        True,
        False,
        False,
        False,
        True,
    ]


def item(command: int, first: float, north_m: float, east_m: float) -> MissionItem:
    return MissionItem(command, 3, (first, 0, 0, 0), *corner(north_m, east_m), 0.0)


def test_fence_items_become_areas() -> None:
    """A return point is none; polygons are as long as they say; circles are one item each."""
    items = [
        item(5000, 0, 0, 0),
        *(item(5001, 3, *place) for place in [(0, 0), (10, 0), (0, 10)]),
        item(5004, 25.0, 40, 40),
        *(item(5002, 3, *place) for place in [(0, 0), (5, 0), (0, 5)]),
    ]
    first, circle, last = areas_from_items(items)
    assert (len(first.corners), first.radius_m, first.stay_inside) == (3, None, True)
    assert (len(circle.corners), circle.radius_m, circle.stay_inside) == (1, 25.0, False)
    assert (len(last.corners), last.stay_inside) == (3, False)


@pytest.mark.parametrize("count", [0, 4], ids=["no corners", "too few items"])
def test_an_invalid_polygon_is_an_error(count: int) -> None:
    """A polygon with fewer items than its first one tells is not guessed at."""
    with pytest.raises(VehicleError, match="fence is invalid"):
        areas_from_items([item(5001, count, 0, 0), item(5001, count, 1, 1)])


@pytest.mark.parametrize("size", [math.nan, math.inf, -math.inf, 1e30, -3.0, 0.0, 2.0], ids=str)
@pytest.mark.parametrize("command", [5001, 5002])
def test_an_impossible_number_of_corners_is_told(command: int, size: float) -> None:
    """A vehicle may send any number."""
    with pytest.raises(VehicleError, match="fence is invalid"):
        areas_from_items([item(command, size, 0, 0), item(command, size, 1, 1)])


@pytest.mark.parametrize("radius_m", [math.nan, math.inf, -25.0, 0.0], ids=str)
@pytest.mark.parametrize("command", [5003, 5004])
def test_an_impossible_radius_is_told(command: int, radius_m: float) -> None:
    """A circle without a radius forbids nothing, or everything."""
    with pytest.raises(VehicleError, match="fence is invalid"):
        areas_from_items([item(command, radius_m, 0, 0)])


def test_a_corner_beyond_the_pole_is_told() -> None:
    """MAVLink's integers reach 214 degrees."""
    beyond = MissionItem(5003, 3, (25.0, 0, 0, 0), 214.0, 8.0, 0.0)
    with pytest.raises(VehicleError, match="fence is invalid"):
        areas_from_items([beyond])


def test_many_areas_are_read_in_linear_time() -> None:
    """60,000 circles take less than a second."""
    began_s = process_time()
    assert len(areas_from_items([item(5004, 25.0, 0, 0)] * 60_000)) == 60_000
    assert process_time() - began_s < 2.0


def test_a_long_leg_takes_little_memory() -> None:
    """A leg of 1,500 km past a fence of 700 corners takes less than 50 MB, and is told right."""
    angles = np.linspace(0, 2 * np.pi, 700, endpoint=False)
    ring = tuple(corner(700e3 + 5e3 * np.cos(angle), 5e3 * np.sin(angle)) for angle in angles)
    starts_m, ends_m = np.zeros((3, 2)), np.array([[1500e3, 0.0], [1500e3, 20e3], [690e3, 0.0]])
    tracemalloc.start()
    crossed = FenceArea(ring, None, False).forbids_legs(starts_m, ends_m, FRAME)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert crossed.tolist() == [True, False, False]
    assert peak < 50e6


def test_many_legs_past_many_corners_take_little_memory() -> None:
    """3,000 legs and 2,000 corners, 6 million pairs, take less than 50 MB."""
    angles = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    ring = tuple(corner(1e3 * np.cos(angle), 1e3 * np.sin(angle)) for angle in angles)
    starts_m = np.column_stack([np.linspace(-2e3, 2e3, 3000), np.full(3000, -2e3)])
    tracemalloc.start()
    crossed = FenceArea(ring, None, False).forbids_legs(starts_m, starts_m + np.array([0.0, 4e3]), FRAME)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert crossed.sum() == np.sum(np.abs(starts_m[:, 0]) < 1e3)
    assert peak < 50e6


def test_a_leg_through_a_small_area_is_found() -> None:
    """Areas narrower than any step along the leg count too, and legs along an edge's line do not."""
    sliver = FenceArea((corner(50, -1), corner(50.01, -1), corner(50.01, 1), corner(50, 1)), None, False)
    circle = FenceArea((corner(50, 0.2),), 0.25, False)
    starts_m = np.array([(0.0, 0.0), (0.0, 2.0), (10.0, -1.0)])
    ends_m = np.array([(100.0, 0.0), (100.0, 2.0), (40.0, -1.0)])
    assert sliver.forbids_legs(starts_m, ends_m, FRAME).tolist() == [True, False, False]
    assert circle.forbids_legs(starts_m, ends_m, FRAME).tolist() == [True, False, False]


@settings(max_examples=50)
@given(st.lists(st.tuples(st.floats(-90, 140), st.floats(-90, 140)), min_size=4, max_size=4), st.booleans())
def test_legs_agree_with_places_along_them(ends: list[tuple[float, float]], stay_inside: bool) -> None:
    """A leg is forbidden if a place every 5 cm along it is, and only if one nearby is."""
    starts_m, ends_m = np.array(ends[:2]), np.array(ends[2:])
    area = polygon(stay_inside)
    for start_m, end_m, forbidden in zip(
        starts_m, ends_m, area.forbids_legs(starts_m, ends_m, FRAME), strict=True
    ):
        places_m = start_m + np.linspace(0, 1, 5000)[:, None] * (end_m - start_m)
        sampled = area.forbids_legs(places_m, places_m, FRAME)
        assert forbidden or not sampled.any()
        if forbidden and not sampled.any():  # Only the clipping of a corner can be missed.
            shifted = [
                area.forbids_legs(places_m + shift, places_m + shift, FRAME).any()
                for shift in ((0.1, 0.1), (-0.1, 0.1), (0.1, -0.1), (-0.1, -0.1))
            ]
            assert any(shifted)


@pytest.mark.parametrize("stay_inside", [True, False], ids=["outside of where it is kept", "in a zone"])
def test_a_vehicle_that_stands_outside_its_fence_is_told_so(stay_inside: bool) -> None:
    """No other part of the log would mend that."""
    state = HERE if not stay_inside else replace(HERE, lat_deg=corner(-30, 0)[0])
    there = Mission((waypoint(*corner(0, 90), 30.0),))
    with pytest.raises(VehicleError, match="the vehicle stands outside its fence; move it inside"):
        check(COPTER, there, state, takeoff_altitude_m=30.0, areas=[polygon(stay_inside)])


def test_a_leg_that_leaves_the_fence_is_refused() -> None:
    """Both ends may be inside and the way between them not."""
    there = Mission((waypoint(*corner(90, 0), 30.0), waypoint(*corner(0, 90), 30.0)))
    with pytest.raises(MissionError, match="the leg to waypoint 2 crosses the vehicle's fence"):
        check(COPTER, there, HERE, takeoff_altitude_m=30.0, areas=[polygon()])
    around = Mission(
        (waypoint(*corner(90, 0), 30.0), waypoint(*corner(0, 0), 30.0), waypoint(*corner(0, 90), 30.0))
    )
    assert check(COPTER, around, HERE, takeoff_altitude_m=30.0, areas=[polygon()]).extent == "3 waypoints, "

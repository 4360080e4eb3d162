"""Fences of polygons and circles: which places they forbid, and how they are read from a vehicle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.errors import MissionError, VehicleError
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
    assert polygon().forbids(PLACES, FRAME).tolist() == [False, False, False, True, True]
    assert polygon(False).forbids(PLACES, FRAME).tolist() == [True, True, True, False, False]


def test_a_circle_keeps_in_or_out() -> None:
    """By ground distance from its centre."""
    circle = FenceArea((corner(0, 0),), 50.0, True)
    assert circle.forbids(PLACES, FRAME).tolist() == [False, True, True, True, False]
    assert replace(circle, stay_inside=False).forbids(PLACES, FRAME).tolist() == [
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
def test_a_fence_that_makes_no_sense_is_told(count: int) -> None:
    """A polygon that is shorter than it says is not guessed at."""
    with pytest.raises(VehicleError, match="cannot be understood"):
        areas_from_items([item(5001, count, 0, 0), item(5001, count, 1, 1)])


def test_a_leg_that_leaves_the_fence_is_refused() -> None:
    """Both ends may be inside and the way between them not."""
    there = Mission((waypoint(*corner(90, 0), 30.0), waypoint(*corner(0, 90), 30.0)))
    with pytest.raises(MissionError, match="the leg to waypoint 2 crosses the vehicle's fence"):
        check(COPTER, there, HERE, takeoff_altitude_m=30.0, areas=[polygon()])
    around = Mission(
        (waypoint(*corner(90, 0), 30.0), waypoint(*corner(0, 0), 30.0), waypoint(*corner(0, 90), 30.0))
    )
    assert check(COPTER, around, HERE, takeoff_altitude_m=30.0, areas=[polygon()]).waypoints == 3

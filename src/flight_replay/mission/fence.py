"""Areas that a vehicle's fence keeps it in or out of: polygons and circles on the map."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.errors import VehicleError
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.mission.items import MissionItem

# MAV_CMD_NAV_FENCE_*: param1 is the number of corners of the polygon, or the radius in metres.
_POLYGON_IN, _POLYGON_OUT, _CIRCLE_IN, _CIRCLE_OUT = 5001, 5002, 5003, 5004


@dataclass(frozen=True, slots=True)
class FenceArea:
    """A polygon of at least three corners (degrees), or a circle of ``radius_m`` around its one corner."""

    corners: tuple[tuple[float, float], ...]
    radius_m: float | None
    stay_inside: bool

    def forbids(self, places_m: Floats, frame: LocalFrame) -> NDArray[np.bool_]:
        """Which of the places (n, 2), metres in ``frame``, the area forbids."""
        corners_m = frame.to_metres(*np.array(self.corners).T)
        if self.radius_m is not None:
            inside = np.linalg.norm(places_m - corners_m[0], axis=1) <= self.radius_m
        else:
            inside = _inside(places_m, corners_m)
        return np.asarray(~inside if self.stay_inside else inside)


def _inside(places: Floats, corners: Floats) -> NDArray[np.bool_]:
    """Which places lie in a polygon: a ray from each crosses the outline an odd number of times."""
    x, y = places[:, 0, None], places[:, 1, None]
    x1, y1 = corners[:, 0], corners[:, 1]
    x2, y2 = np.roll(x1, -1), np.roll(y1, -1)
    straddles = (y1 > y) != (y2 > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = x1 + (y - y1) * (x2 - x1) / (y2 - y1)
    return np.asarray((straddles & (x < crossing)).sum(axis=1) % 2 == 1)


def active_fence_types(parameters: Mapping[str, float]) -> int:
    """The bits of FENCE_TYPE of a fence that is on, or goes on by itself once the vehicle flies; else 0.

    Raises:
        VehicleError: A value that counts is not a number.
    """
    if not (parameters.get("FENCE_ENABLE") or parameters.get("FENCE_AUTOENABLE")):
        return 0
    for name, value in parameters.items():
        if name.startswith("FENCE_") and not math.isfinite(value):
            raise VehicleError(f"the vehicle's fence cannot be understood: {name} is {value:g}; set it anew")
    return int(parameters.get("FENCE_TYPE", 0))


def areas_from_items(items: Sequence[MissionItem]) -> tuple[FenceArea, ...]:
    """The areas that fence items describe; a polygon is as many items as its first one says.

    Raises:
        VehicleError: A polygon is cut short.
    """
    areas: list[FenceArea] = []
    rest = [item for item in items if _POLYGON_IN <= item.command <= _CIRCLE_OUT]
    while rest:
        first = rest[0]
        count = int(first.params[0]) if first.command in (_POLYGON_IN, _POLYGON_OUT) else 1
        corners, rest = rest[:count], rest[count:]
        if count < 1 or len(corners) != count or any(corner.command != first.command for corner in corners):
            raise VehicleError("the fence on board cannot be understood; check it with a ground station")
        radius_m = first.params[0] if first.command in (_CIRCLE_IN, _CIRCLE_OUT) else None
        places = tuple((corner.lat_deg, corner.lon_deg) for corner in corners)
        areas.append(FenceArea(places, radius_m, first.command in (_POLYGON_IN, _CIRCLE_IN)))
    return tuple(areas)

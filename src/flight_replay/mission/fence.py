"""Areas that a vehicle's fence keeps it in or out of: polygons and circles on the map."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntFlag

import numpy as np

from flight_replay.exceptions import VehicleError
from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.geometry.polyline import nearest_on_segments
from flight_replay.mission.items import MissionItem

# MAV_CMD_NAV_FENCE_*: param1 is the number of corners of the polygon, or the radius in metres.
_POLYGON_IN, _POLYGON_OUT, _CIRCLE_IN, _CIRCLE_OUT = 5001, 5002, 5003, 5004
_MIN_CORNERS = 3
_INVALID = "the vehicle's fence is invalid; upload it again with a ground station"
_PAIRS_AT_ONCE = 100_000  # Legs times corners: some 10 MB of working memory.


class FenceType(IntFlag):
    """Bits of FENCE_TYPE (AC_Fence.h)."""

    ALT_MAX = 1
    CIRCLE = 2
    AREAS = 4
    ALT_MIN = 8


@dataclass(frozen=True, slots=True)
class FenceArea:
    """A polygon of at least three corners (degrees), or a circle of ``radius_m`` around a single one."""

    corners: tuple[tuple[float, float], ...]
    radius_m: float | None
    stay_inside: bool

    def forbids_legs(self, starts_m: Floats, ends_m: Floats, frame: LocalFrame) -> Flags:
        """Which straight legs (n,) pass a position that the area forbids.

        Args:
            starts_m: Where the legs start (n, 2), metres in ``frame``.
            ends_m: Where they end (n, 2).
            frame: The frame of those positions.
        """
        corners_m = frame.to_metres(*np.array(self.corners).T)
        if self.radius_m is not None:
            return self._circle_forbids(starts_m - corners_m[0], ends_m - corners_m[0])
        rows = max(_PAIRS_AT_ONCE // len(corners_m), 1)
        parts = [slice(first, first + rows) for first in range(0, len(starts_m), rows)]
        forbidden = [self._polygon_forbids(starts_m[part], ends_m[part], corners_m) for part in parts]
        return np.concatenate([np.zeros(0, np.bool_), *forbidden])

    def _circle_forbids(self, starts_m: Floats, ends_m: Floats) -> Flags:
        """Legs from ``starts_m`` to ``ends_m`` (n, 2), both counted from the centre."""
        radius_m = self.radius_m or 0.0
        if self.stay_inside:
            return np.maximum(_length(starts_m), _length(ends_m)) > radius_m
        return nearest_on_segments(np.zeros(2), starts_m, ends_m - starts_m)[1] <= radius_m

    def _polygon_forbids(self, starts_m: Floats, ends_m: Floats, corners_m: Floats) -> Flags:
        """Legs that cross the outline, start or end on its wrong side."""
        starts_inside, ends_inside = _inside(starts_m, corners_m), _inside(ends_m, corners_m)
        wrong_side = ~(starts_inside & ends_inside) if self.stay_inside else starts_inside | ends_inside
        return wrong_side | _cross(starts_m, ends_m, corners_m)


def _length(vectors: Floats) -> Floats:
    return np.hypot(vectors[:, 0], vectors[:, 1])


def _inside(positions: Floats, corners: Floats) -> Flags:
    """Which positions lie in a polygon: a ray from each crosses the outline an odd number of times."""
    x, y = positions[:, 0, None], positions[:, 1, None]
    x1, y1 = corners[:, 0], corners[:, 1]
    x2, y2 = np.roll(x1, -1), np.roll(y1, -1)
    straddles = (y1 > y) != (y2 > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = x1 + (y - y1) * (x2 - x1) / (y2 - y1)
    return np.asarray((straddles & (x < crossing)).sum(axis=1) % 2 == 1)


def _cross(starts: Floats, ends: Floats, corners: Floats) -> Flags:
    """Which legs (n,) cross a polygon's outline: each has its ends on both sides of the other's line."""
    following = np.roll(corners, -1, axis=0)
    corner_left = _is_left(corners, starts[:, None], ends[:, None])
    outline_straddles = corner_left != np.roll(corner_left, -1, axis=1)
    leg_straddles = _is_left(starts[:, None], corners, following) != _is_left(
        ends[:, None], corners, following
    )
    return np.asarray((outline_straddles & leg_straddles).any(axis=1))


def _is_left(positions: Floats, starts: Floats, ends: Floats) -> Flags:
    """Whether ``positions`` lie to the left of the lines from ``starts`` to ``ends``."""
    lines, offsets = ends - starts, positions - starts
    return np.asarray(lines[..., 0] * offsets[..., 1] > lines[..., 1] * offsets[..., 0])


def active_fence_types(parameters: Mapping[str, float]) -> FenceType:
    """What FENCE_TYPE says of a fence that is on, or goes on by itself once the vehicle flies; else none.

    Raises:
        VehicleError: A value that counts is not a number.
    """
    if not (parameters.get("FENCE_ENABLE") or parameters.get("FENCE_AUTOENABLE")):
        return FenceType(0)
    for name, value in parameters.items():
        if name.startswith("FENCE_") and not math.isfinite(value):
            raise VehicleError(f"the vehicle's parameter {name} is {value:g}, not a number; set it again")
    return FenceType(int(parameters.get("FENCE_TYPE", 0)))


def areas_from_items(items: Sequence[MissionItem]) -> tuple[FenceArea, ...]:
    """The areas that fence items describe; a polygon is as many items as its first one says.

    Raises:
        VehicleError: A polygon has too few items, or a count, radius or corner is invalid.
    """
    areas: list[FenceArea] = []
    shapes = [item for item in items if _POLYGON_IN <= item.command <= _CIRCLE_OUT]
    at = 0
    while at < len(shapes):
        first = shapes[at]
        size = first.params[0]
        is_circle = first.command in (_CIRCLE_IN, _CIRCLE_OUT)
        if not math.isfinite(size) or (size <= 0 if is_circle else size < _MIN_CORNERS):
            raise VehicleError(_INVALID)
        corners = shapes[at : at + (1 if is_circle else min(int(size), len(shapes) + 1))]
        _check_corners(first, corners, 1 if is_circle else int(size))
        at += len(corners)
        positions = tuple((corner.lat_deg, corner.lon_deg) for corner in corners)
        areas.append(
            FenceArea(positions, size if is_circle else None, first.command in (_POLYGON_IN, _CIRCLE_IN))
        )
    return tuple(areas)


def _check_corners(first: MissionItem, corners: Sequence[MissionItem], count: int) -> None:
    """Raise unless there are ``count`` corners on earth, all of the kind of the first one."""
    kinds = {corner.command for corner in corners}
    on_earth = all(abs(corner.lat_deg) <= 90 and abs(corner.lon_deg) <= 180 for corner in corners)
    if len(corners) != count or kinds != {first.command} or not on_earth:
        raise VehicleError(_INVALID)

"""What is refused before anything is uploaded, and what a person sees before a real vehicle is armed.

Pure checks over plain data. Home counts as where the vehicle stands: ArduCopter sets it there when
it is armed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntFlag
from typing import TYPE_CHECKING

import numpy as np

from flight_replay.errors import MissionError, VehicleError
from flight_replay.events import VehicleState
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.mission.fence import FenceArea, active_fence_types
from flight_replay.mission.items import Frame, Mission, MissionItem

if TYPE_CHECKING:
    from flight_replay.vehicle.identity import Identity

MAX_DISTANCE_M = 1000.0
"""How far from home a route may begin, unless asked otherwise."""
_FLYABLE_FRAMES = frozenset({Frame.ABSOLUTE, Frame.RELATIVE, Frame.TERRAIN})


_AREA_STEP_M = 1.0


class _Fence(IntFlag):
    """Bits of FENCE_TYPE (AC_Fence.h)."""

    ALT_MAX = 1
    CIRCLE = 2
    ALT_MIN = 8


@dataclass(frozen=True, slots=True)
class Briefing:
    """What a person should know before a vehicle is armed: degrees, metres, volts, percent."""

    vehicle: str
    lat_deg: float
    lon_deg: float
    battery_v: float | None
    battery_percent: float | None
    waypoints: int
    first_m: float
    farthest_m: float
    highest_m: float

    @property
    def lines(self) -> tuple[str, ...]:
        """The same in words."""
        battery = "unknown" if self.battery_v is None else f"{self.battery_v:.1f} V"
        if self.battery_percent is not None:
            battery += f", {self.battery_percent:.0f} %"
        return (
            f"Vehicle: {self.vehicle}",
            f"Position: {self.lat_deg:.7f}, {self.lon_deg:.7f}",
            f"Battery: {battery}",
            f"First waypoint: {self.first_m:.0f} m away",
            f"Route: {self.waypoints} waypoints, up to {self.farthest_m:.0f} m away "
            f"and {self.highest_m:.0f} m up",
        )


def check(  # noqa: PLR0913
    identity: Identity,
    mission: Mission,
    at: VehicleState,
    *,
    takeoff_altitude_m: float,
    max_distance_m: float = MAX_DISTANCE_M,
    areas: Sequence[FenceArea] = (),
) -> Briefing:
    """Refuse a vehicle or a route that must not be flown; else, what to know before it is.

    Args:
        identity: What the vehicle is, with its fence parameters.
        mission: What would be uploaded.
        at: Where the vehicle stands.
        takeoff_altitude_m: Metres above home.
        max_distance_m: Farthest from home that the first waypoint may be, metres.
        areas: The polygons and circles of the vehicle's fence.

    Raises:
        VehicleError: The vehicle is not a multicopter flown by ArduPilot, or its motors run already.
        MissionError: The route begins too far away, leaves the fence, or has a place that cannot be flown to.
    """
    _check_vehicle(identity, at)
    for seq, item in mission.waypoints:
        _check_place(seq, item)
    distances_m = _distances_m(mission, at)
    _check_distance(float(distances_m[0]), max_distance_m)
    _check_areas(areas, mission, at)
    heights_m = np.append(_heights_m(mission), takeoff_altitude_m)
    _check_fence(identity.parameters, distances_m, heights_m)
    return _briefing(identity, at, distances_m, heights_m)


def _briefing(identity: Identity, at: VehicleState, distances_m: Floats, heights_m: Floats) -> Briefing:
    """``distances_m`` (n,) from the vehicle to each waypoint, ``heights_m`` (m,) that are flown at."""
    return Briefing(
        vehicle=identity.name,
        lat_deg=at.lat_deg,
        lon_deg=at.lon_deg,
        battery_v=at.battery_v,
        battery_percent=at.battery_percent,
        waypoints=len(distances_m),
        first_m=float(distances_m[0]),
        farthest_m=float(distances_m.max()),
        highest_m=float(heights_m.max()),
    )


def _check_vehicle(identity: Identity, at: VehicleState) -> None:
    if not identity.is_multicopter:
        raise VehicleError(f"{identity.name} is not a multicopter flown by ArduPilot; connect one")
    if at.armed:
        raise VehicleError(
            f"the vehicle is already armed, in mode {at.mode}; land and disarm it, then start again"
        )


def _check_distance(first_m: float, max_distance_m: float) -> None:
    if first_m > max_distance_m:
        raise MissionError(
            f"the first waypoint is {first_m:.0f} m from the vehicle, and {max_distance_m:.0f} m "
            "are allowed; bring the vehicle there, or allow more with --max-distance"
        )


def _check_place(seq: int, item: MissionItem) -> None:
    if item.frame not in _FLYABLE_FRAMES:
        raise MissionError(f"waypoint {seq} has altitude frame {item.frame}, which ArduCopter does not fly")
    if not np.isfinite([item.lat_deg, item.lon_deg, item.alt_m]).all() or abs(item.lat_deg) > 90.0:
        raise MissionError(f"waypoint {seq} is nowhere: {item.lat_deg}, {item.lon_deg}, {item.alt_m} m")
    if item.frame != Frame.ABSOLUTE and item.alt_m <= 0:
        raise MissionError(f"waypoint {seq} is {item.alt_m:g} m above home; fly higher with --altitude")


def _distances_m(mission: Mission, at: VehicleState) -> Floats:
    """Ground distance of each waypoint from the vehicle, metres."""
    places = [item for _, item in mission.waypoints]
    frame = LocalFrame(at.lat_deg, at.lon_deg)
    north_east_m = frame.to_metres([p.lat_deg for p in places], [p.lon_deg for p in places])
    return np.asarray(np.hypot(north_east_m[:, 0], north_east_m[:, 1]))


def _check_areas(areas: Sequence[FenceArea], mission: Mission, at: VehicleState) -> None:
    """Refuse a way (straight from place to place, from where the vehicle stands) into what is forbidden."""
    frame = LocalFrame(at.lat_deg, at.lon_deg)
    places = [(at.lat_deg, at.lon_deg), *((item.lat_deg, item.lon_deg) for _, item in mission.waypoints)]
    stops_m = frame.to_metres(*np.array(places).T)
    for (seq, _), begin_m, end_m in zip(mission.waypoints, stops_m[:-1], stops_m[1:], strict=True):
        steps = max(int(np.linalg.norm(end_m - begin_m) / _AREA_STEP_M), 1)
        way_m = begin_m + np.linspace(0, 1, steps + 1)[:, None] * (end_m - begin_m)
        if any(area.forbids(way_m, frame).any() for area in areas):
            raise MissionError(
                f"the way to waypoint {seq} crosses the vehicle's fence; choose another part of the log, "
                "or change the fence"
            )


def _heights_m(mission: Mission) -> Floats:
    """Height of each waypoint above home, metres, as far as it is known; over terrain counts as over home."""
    home_amsl_m = mission.home.alt_amsl_m if mission.home else 0.0
    return np.array(
        [item.alt_m - (home_amsl_m if item.frame == Frame.ABSOLUTE else 0.0) for _, item in mission.waypoints]
    )


def _check_fence(parameters: Mapping[str, float], distances_m: Floats, heights_m: Floats) -> None:
    kinds = _Fence(active_fence_types(parameters) & (_Fence.ALT_MAX | _Fence.CIRCLE | _Fence.ALT_MIN))
    margin_m = parameters.get("FENCE_MARGIN", 0.0)
    bounds = (
        (_Fence.CIRCLE, "FENCE_RADIUS", "m away", distances_m.max(), 1.0),
        (_Fence.ALT_MAX, "FENCE_ALT_MAX", "m up", heights_m.max(), 1.0),
        (_Fence.ALT_MIN, "FENCE_ALT_MIN", "m up", heights_m.min(), -1.0),
    )
    for kind, name, unit, reach_m, outward in bounds:
        if kind in kinds and name in parameters and outward * (reach_m - parameters[name]) > -margin_m:
            raise MissionError(
                f"the route goes {reach_m:.0f} {unit}, and the vehicle's fence ends at {name} "
                f"{parameters[name]:g} m, less a margin of {margin_m:g} m; choose another part of the log, "
                "or change the fence"
            )

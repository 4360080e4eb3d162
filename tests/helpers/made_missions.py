"""Missions made up for the flight model: straight, spline and mixed, with speeds, delays and climbs."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.mission.items import Home, Mission, MissionItem, change_speed, waypoint

KINDS = ("straight", "spline", "mixed")


def mission_at(
    places_m: Sequence[tuple[float, float, float]],
    *,
    spline: bool = False,
    home: Home = Home(47.0, 8.0, 400.0),  # noqa: B008
) -> Mission:
    """Waypoints at metres north, east and up of home."""
    frame = FlatFrame(home.lat_deg, home.lon_deg)
    items = []
    for north, east, up in places_m:
        lat, lon = frame.to_degrees((north, east))
        items.append(waypoint(float(lat), float(lon), up, spline=spline))
    return Mission(tuple(items), home)


def random_mission(seed: int) -> Mission:
    """A mission of 6 to 25 waypoints with legs of 1 to 100 m; the seed decides everything."""
    chance = random.Random(seed)
    kind = KINDS[seed % len(KINDS)]
    home = Home(chance.uniform(-60, 65), chance.uniform(-180, 180), float(chance.randint(0, 800)))
    frame = FlatFrame(home.lat_deg, home.lon_deg)
    legs = math.exp(chance.uniform(0.0, math.log(30.0)))
    north, east, up, course = 0.0, 0.0, float(chance.randint(15, 30)), chance.uniform(0, 2 * math.pi)
    items: list[MissionItem] = []
    for i in range(chance.randint(6, 25)):
        length = min(100.0, max(1.0, legs * math.exp(chance.gauss(0.0, 0.8))))
        course += chance.gauss(0.0, 0.9)
        north, east = north + length * math.cos(course), east + length * math.sin(course)
        if math.hypot(north, east) > 300:
            course += math.pi
        if chance.random() < 0.3:
            up = max(10.0, up + chance.uniform(-0.5, 0.5) * length)
        if i and chance.random() < 0.2:
            items.append(change_speed(chance.uniform(1.0, 12.0)))
        lat, lon = frame.to_degrees((north, east))
        spline = kind == "spline" or (kind == "mixed" and chance.random() < 0.5)
        hold_s = float(chance.choice((1, 2, 4))) if chance.random() < 0.12 else 0.0
        items.append(
            waypoint(round(float(lat), 7), round(float(lon), 7), round(up, 2), hold_s=hold_s, spline=spline)
        )
    return Mission(tuple(items), home)

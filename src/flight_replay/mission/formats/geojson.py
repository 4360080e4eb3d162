"""GeoJSON (RFC 7946): every mission item as a feature, the route and the track as lines.

Lines are cut where they cross the antimeridian, as section 3.1.9 asks. Third coordinates are metres
above mean sea level, and left out of a geometry where one of them is not known. The track's properties
hold its other columns, one value a fix: ``logs/tracks/geojson_reader.py`` reads the same track again.
"""

from __future__ import annotations

import json
import math
from itertools import pairwise
from typing import Any

import numpy as np

from flight_replay.logs.track import Armed, Track
from flight_replay.mission.formats.item_text import (
    amsl_m,
    command_name,
    description,
    route_line,
    speeds_m_s,
    utc_texts,
)
from flight_replay.mission.items import FIRST_SEQ, Home, Mission, MissionItem

_COLUMNS = {
    "time_s": 6,
    "alt_m": 3,
    "amsl_m": 3,
    "north_m_s": 3,
    "east_m_s": 3,
    "up_m_s": 3,
    "heading_deg": 3,
    "boot": 0,
    "armed": 0,
}
"""A track's columns besides its line, and their digits."""
_USUAL = {"boot": 0, "armed": Armed.UNKNOWN}
"""What columns are taken to be that are left out."""
Place = tuple[float, float, float]
"""Latitude and longitude in degrees, height above mean sea level in metres or not a number."""


def text(mission: Mission, track: Track | None = None, start_utc_s: float | None = None) -> str:
    """The mission, and the recorded track if there is one.

    It has the property ``start_utc`` with ``start_utc_s``, the Unix time of its first fix.
    """
    features = [_home_feature(mission.home)] if mission.home is not None else []
    speeds = speeds_m_s(mission)
    for seq, item in enumerate(mission.items, FIRST_SEQ):
        features.append(_item_feature(seq, item, mission.home, speeds.get(seq)))
    route, above_sea = route_line(mission)
    if len(route) > 1:
        heights = route[:, 2] if above_sea else np.full(len(route), np.nan)
        places = zip(route[:, 0].tolist(), route[:, 1].tolist(), heights.tolist(), strict=True)
        features.append(_feature(_line(list(places)), {"kind": "route", "name": "Route"}))
    if track is not None and len(track) > 1:
        features.append(_track_feature(track, start_utc_s))
    collection = {"type": "FeatureCollection", "features": features}
    return json.dumps(collection, indent=1, allow_nan=False) + "\n"


def _home_feature(home: Home) -> dict[str, Any]:
    place = (home.lat_deg, home.lon_deg, home.amsl_m)
    return _feature(_point(place), {"kind": "home", "name": "Home", "alt_amsl_m": home.alt_amsl_m})


def _item_feature(seq: int, item: MissionItem, home: Home | None, speed_m_s: float | None) -> dict[str, Any]:
    properties = {
        "kind": "item",
        "name": str(seq),
        "seq": seq,
        "command": int(item.command),
        "command_name": command_name(item),
        "frame": int(item.frame),
        "params": [number if math.isfinite(number) else None for number in item.params],
    }
    if not item.is_waypoint:
        return _feature(None, properties)
    properties |= {"description": description(item), "alt_m": item.alt_m, "hold_s": item.hold_s}
    if speed_m_s is not None:
        properties["speed_m_s"] = speed_m_s
    return _feature(_point((item.lat_deg, item.lon_deg, amsl_m(item, home))), properties)


def _track_feature(track: Track, start_utc_s: float | None) -> dict[str, Any]:
    places = zip(track.lat_deg.tolist(), track.lon_deg.tolist(), track.amsl_m.tolist(), strict=True)
    columns = {name: values for name, digits in _COLUMNS.items() if (values := _values(track, name, digits))}
    properties: dict[str, Any] = {"kind": "track", "name": "Recorded track"}
    if start_utc_s is not None and track.timed:
        properties["start_utc"] = utc_texts(track.select(slice(1)), start_utc_s)[0]
    return _feature(_line(list(places)), properties | columns)


def _values(track: Track, name: str, digits: int) -> list[float | None]:
    """A column of a track, null where unknown; nothing at all where it tells nothing."""
    column = getattr(track, name)
    is_empty = not np.isfinite(column).any() or (name == "time_s" and not track.timed)
    in_line = name == "amsl_m" and np.isfinite(column).all()
    if is_empty or in_line or (name in _USUAL and (column == _USUAL[name]).all()):
        return []
    return [round(value, digits) if math.isfinite(value) else None for value in column.tolist()]


def _feature(geometry: dict[str, Any] | None, properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": properties}


def _point(place: Place) -> dict[str, Any]:
    return {"type": "Point", "coordinates": _coordinates([place])[0]}


def _line(places: list[Place]) -> dict[str, Any]:
    parts = [_coordinates(part) for part in _cut_at_antimeridian(places)]
    if len(parts) == 1:
        return {"type": "LineString", "coordinates": parts[0]}
    return {"type": "MultiLineString", "coordinates": parts}


def _coordinates(places: list[Place]) -> list[list[float]]:
    rows = [[round(lon_deg, 8), round(lat_deg, 8)] for lat_deg, lon_deg, _ in places]
    heights_m = [height_m for _, _, height_m in places]
    if not all(map(math.isfinite, heights_m)):
        return rows
    return [[*row, round(height_m, 3)] for row, height_m in zip(rows, heights_m, strict=True)]


def _cut_at_antimeridian(places: list[Place]) -> list[list[Place]]:
    """The line in parts that stay on one side, each cut end given to both."""
    parts = [[places[0]]]
    for (lat1, lon1, height1_m), (lat2, lon2, height2_m) in pairwise(places):
        if abs(lon2 - lon1) > 180:
            side = math.copysign(180.0, lon1)
            ahead_deg = lon2 + 2 * side - lon1
            share = (side - lon1) / ahead_deg if ahead_deg else 0.0
            lat, height_m = lat1 + share * (lat2 - lat1), height1_m + share * (height2_m - height1_m)
            parts[-1].append((lat, side, height_m))
            parts.append([(lat, -side, height_m)])
        parts[-1].append((lat2, lon2, height2_m))
    return parts

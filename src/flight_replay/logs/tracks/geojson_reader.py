"""GeoJSON (RFC 7946): the track that ``--save FILE.geojson`` writes, or any line.

Third coordinates are above mean sea level. Times of others' lines stand in ``coordinateProperties.times``
or ``coordTimes``, as toGeoJSON writes them.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Floats
from flight_replay.logs.byte_source import OpenLog, Progress, contents
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import COLUMNS
from flight_replay.logs.tracks.byte_pieces import encoding_of
from flight_replay.logs.tracks.longest_line import longest_line
from flight_replay.logs.tracks.point_times import are_timed
from flight_replay.logs.tracks.recorded_columns import columns_recording
from flight_replay.logs.tracks.text_values import unix_time_s
from flight_replay.logs.tracks.track_points import PointCollector
from flight_replay.logs.tracks.track_recording import TrackFile, track_recording
from flight_replay.logs.vehicles import VehicleId

_MOST_BYTES = 64 << 20
_NAN = float("nan")
Place = Sequence[float]


def read_geojson(log: OpenLog, _vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read a GeoJSON file; see ``log_formats.Read``."""
    data = contents(log, _MOST_BYTES, progress)
    file = TrackFile(name=log.name, bytes=len(data))
    try:
        features = list(_features(json.loads(data.decode(encoding_of(data)))))
    except (ValueError, RecursionError) as error:
        raise LogError(f"{log.name} is not valid JSON ({error}); name another log") from None
    saved = next((each for each in features if each[1].get("kind") == "track"), None)
    if saved is not None:
        columns = _saved_columns(*saved)
        return columns_recording(columns, file, _utc_s(columns, saved[1].get("start_utc")))
    collector = PointCollector(log.name)
    for lines, properties in features:
        _add(collector, lines, _times_s(properties))
    points = collector.points()
    notes: list[str] = []
    if len(points) and not are_timed(points):
        points, notes = longest_line(points)
    return track_recording(points, replace(file, notes=notes))


def _features(value: object) -> Iterator[tuple[list[list[Place]], Mapping[str, Any]]]:
    """The lines of each feature that has some, and its properties."""
    if not isinstance(value, dict):
        return
    features = value.get("features") if value.get("type") == "FeatureCollection" else [value]
    for feature in features if isinstance(features, list) else []:
        if not isinstance(feature, dict):
            continue
        is_feature = feature.get("type") == "Feature"
        geometry = feature.get("geometry") if is_feature else feature
        properties = feature.get("properties") if is_feature else {}
        lines = _lines(geometry)
        if lines:
            yield lines, properties if isinstance(properties, dict) else {}


def _lines(geometry: object) -> list[list[Place]]:
    """The lines of a geometry, each a list of places as longitude, latitude and maybe height."""
    if not isinstance(geometry, dict):
        return []
    kind, coordinates = geometry.get("type"), geometry.get("coordinates")
    parts = [coordinates] if kind == "LineString" else coordinates if kind == "MultiLineString" else []
    lines = [_places(part) for part in (parts if isinstance(parts, list) else [])]
    return [line for line in lines if line]


def _places(part: object) -> list[Place]:
    """The places of a line, those that are none as unknown ones."""
    return [_place(each) for each in part] if isinstance(part, list) else []


def _place(value: object) -> Place:
    values = value if isinstance(value, list) else []
    return [_number(each) for each in values[:3]] + [_NAN] * (3 - len(values[:3]))


def _number(value: object) -> float:
    """A JSON value as a number, not a number if it is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return _NAN
    try:
        number = float(value)
    except OverflowError:
        return _NAN
    return number if math.isfinite(number) else _NAN


def _saved_columns(lines: list[list[Place]], properties: Mapping[str, Any]) -> dict[str, Floats]:
    """The columns of a track that was saved; the places where the antimeridian cuts it are no fixes."""
    places: list[Place] = []
    for nth, line in enumerate(lines):
        places += line[min(nth, 1) : len(line) - (nth < len(lines) - 1)]
    rows = np.array(places, float).reshape(-1, 3)
    columns = {"lon_deg": rows[:, 0], "lat_deg": rows[:, 1], "amsl_m": rows[:, 2]}
    for name in COLUMNS:
        values = properties.get(name)
        if isinstance(values, list) and len(values) == len(rows):
            columns[name] = np.array([_number(value) for value in values])
    return columns


def _utc_s(columns: Mapping[str, Floats], start: object) -> Floats | None:
    """The Unix times of a saved track's fixes (n,) by that of the first."""
    if not isinstance(start, str) or "time_s" not in columns:
        return None
    return np.asarray(columns["time_s"] - columns["time_s"][0] + unix_time_s(start))


def _times_s(properties: Mapping[str, Any]) -> list[list[float]]:
    """The Unix times of each line of a feature."""
    inner = properties.get("coordinateProperties")
    times = inner.get("times") if isinstance(inner, dict) else properties.get("coordTimes")
    if not isinstance(times, list):
        return []
    nested = times if times and isinstance(times[0], list) else [times]
    return [
        [unix_time_s(each) if isinstance(each, str) else _NAN for each in line]
        for line in nested
        if isinstance(line, list)
    ]


def _add(collector: PointCollector, lines: list[list[Place]], times_s: list[list[float]]) -> None:
    """Add the lines of a feature: one track of so many segments."""
    collector.begin_track()
    for nth, line in enumerate(lines):
        collector.begin_segment()
        times = times_s[nth] if nth < len(times_s) and len(times_s[nth]) == len(line) else [_NAN] * len(line)
        for (lon_deg, lat_deg, amsl_m), utc_s in zip(line, times, strict=True):
            collector.add(lat_deg, lon_deg, utc_s=utc_s, amsl_m=amsl_m)

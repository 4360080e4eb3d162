"""Tracks as other programs write them."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from datetime import datetime, timedelta, timezone

from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.log_formats import recognised
from flight_replay.logs.read_log import read_open_log
from flight_replay.logs.recording import Recording

START = datetime(2026, 3, 1, 10, 0, tzinfo=timezone.utc)
START_S = START.timestamp()


Point = tuple[float | None, float, float, float]
"""Seconds since ``START`` or None, latitude, longitude, height."""


def read_bytes(data: bytes, name: str = "made") -> Recording:
    """What is read of a file of these bytes, its format found by them."""
    return read_open_log(OpenLog(name, io.BytesIO(data)))


def kind_of_bytes(data: bytes) -> str:
    """The name of the format that a file of these bytes has."""
    return recognised(OpenLog("made", io.BytesIO(data))).name


def moving(
    count: int = 60,
    speed_m_s: float = 5.0,
    step_s: float = 1.0,
    *,
    still: int = 10,
    timed: bool = True,
    start_s: float = 0.0,
) -> list[Point]:
    """Points at rest, then northwards and climbing by 1 m a step: time, latitude, longitude, height."""
    points: list[Point] = []
    for n in range(count):
        along_m = max(n - still, 0) * speed_m_s * step_s
        height_m = 400.0 + max(n - still, 0)
        points.append((start_s + n * step_s if timed else None, 47.0 + along_m / 111_170, 8.0, height_m))
    return points


def utc(time_s: float, digits: int = 0) -> str:
    """A time as ISO 8601 in UTC."""
    text = (START + timedelta(seconds=time_s)).strftime("%Y-%m-%dT%H:%M:%S.%f")
    return (text[: 20 + digits] if digits else text[:19]) + "Z"


def gpx(*segments: Sequence[Point], digits: int = 0) -> bytes:
    """A GPX file of one track."""
    return gpx_of([segments], digits=digits)


def gpx_of(tracks: Sequence[Sequence[Sequence[Point]]], *, digits: int = 0) -> bytes:
    """A GPX file of tracks of segments."""
    lines = ['<?xml version="1.0"?>', '<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1">']
    for track in tracks:
        lines.append("<trk>")
        for segment in track:
            lines.append("<trkseg>")
            for time_s, lat, lon, height in segment:
                time = "" if time_s is None else f"<time>{utc(time_s, digits)}</time>"
                lines.append(f'<trkpt lat="{lat:.8f}" lon="{lon:.8f}"><ele>{height:.3f}</ele>{time}</trkpt>')
            lines.append("</trkseg>")
        lines.append("</trk>")
    return "\n".join([*lines, "</gpx>"]).encode()


def kml(*features: str) -> bytes:
    """A KML file of features."""
    head = '<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="http://www.opengis.net/kml/2.2" '
    return (head + 'xmlns:gx="http://www.google.com/kml/ext/2.2"><Document>' + "".join(features)).encode() + (
        b"</Document></kml>"
    )


def kml_track(points: Sequence[Point], mode: str = "absolute") -> str:
    """A placemark with a gx:Track."""
    whens = "".join(f"<when>{utc(time_s or 0.0)}</when>" for time_s, *_ in points)
    coords = "".join(f"<gx:coord>{lon:.8f} {lat:.8f} {height}</gx:coord>" for _, lat, lon, height in points)
    mode = f"<altitudeMode>{mode}</altitudeMode>"
    return f"<Placemark><gx:Track>{mode}{whens}{coords}</gx:Track></Placemark>"


def kml_points(points: Sequence[Point], mode: str = "absolute") -> str:
    """A placemark with a time for each point."""
    return "".join(
        f"<Placemark><TimeStamp><when>{utc(time_s or 0.0)}</when></TimeStamp><Point>"
        f"<altitudeMode>{mode}</altitudeMode><coordinates>{lon:.8f},{lat:.8f},{height}</coordinates>"
        "</Point></Placemark>"
        for time_s, lat, lon, height in points
    )


def kml_line(points: Sequence[Point], mode: str = "absolute", name: str = "a line") -> str:
    """A placemark with a line."""
    places = "\n".join(f"{lon:.8f},{lat:.8f},{height}" for _, lat, lon, height in points)
    mode = f"<altitudeMode>{mode}</altitudeMode>" if mode else ""
    return (
        f"<Placemark><name>{name}</name><LineString>{mode}<coordinates>\n{places}\n</coordinates></LineString>"
        "</Placemark>"
    )


def kmz(content: bytes, name: str = "doc.kml", others: Sequence[tuple[str, bytes]] = ()) -> bytes:
    """A ZIP archive of other files, then of one of that name."""
    page = io.BytesIO()
    with zipfile.ZipFile(page, "w", zipfile.ZIP_DEFLATED) as archive:
        for other, data in (*others, (name, content)):
            archive.writestr(other, data)
    return page.getvalue()

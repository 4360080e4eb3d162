"""GPX 1.1 (topografix.com/GPX/1/1): the mission as a route, the track as a track with one segment a boot.

Elevations are above mean sea level, and left out where that is not known, and so are times of day. What GPX
has no word for stands in extensions.
"""

from __future__ import annotations

import math
from xml.etree import ElementTree as Xml

import numpy as np

from flight_replay.logs.track import Track
from flight_replay.logs.tracks.gpx_reader import OUR_CREATOR, OUR_HOME
from flight_replay.mission.formats.item_text import amsl_m, command_name, description, speeds_m_s, utc_texts
from flight_replay.mission.items import Mission

_NAMESPACE = "http://www.topografix.com/GPX/1/1"
_OURS = "https://pypi.org/project/flight-replay/gpx"


def text(mission: Mission, track: Track | None = None, start_utc_s: float | None = None) -> str:
    """The mission, and the recorded track if there is one.

    Its points have times with ``start_utc_s``, the Unix time of its first fix.
    """
    attributes = {"version": "1.1", "creator": OUR_CREATOR, "xmlns": _NAMESPACE, "xmlns:replay": _OURS}
    root = Xml.Element("gpx", attributes)
    if mission.home is not None:
        home = mission.home
        point = _point(root, "wpt", home.lat_deg, home.lon_deg, home.amsl_m)
        _child(point, "name", OUR_HOME)
    if mission.waypoints:
        _add_route(root, mission)
    if track is not None and len(track):
        _add_track(root, track, start_utc_s)
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _add_route(root: Xml.Element, mission: Mission) -> None:
    route = Xml.SubElement(root, "rte")
    _child(route, "name", "Mission")
    speeds = speeds_m_s(mission)
    for seq, item in mission.waypoints:
        point = _point(route, "rtept", item.lat_deg, item.lon_deg, amsl_m(item, mission.home))
        _child(point, "name", str(seq))
        _child(point, "desc", description(item))
        _child(point, "type", command_name(item))
        extensions = Xml.SubElement(point, "extensions")
        _child(extensions, "replay:alt_m", f"{item.alt_m:g}")
        _child(extensions, "replay:frame", str(int(item.frame)))
        _child(extensions, "replay:hold_s", f"{item.hold_s:g}")
        if seq in speeds:
            _child(extensions, "replay:speed_m_s", f"{speeds[seq]:g}")


def _add_track(root: Xml.Element, track: Track, start_utc_s: float | None) -> None:
    times = np.array([""] * len(track) if start_utc_s is None else utc_texts(track, start_utc_s))
    element = Xml.SubElement(root, "trk")
    _child(element, "name", "Recorded track")
    for boot in np.unique(track.boot):
        segment = Xml.SubElement(element, "trkseg")
        part = track.select(track.boot == boot)
        columns = part.lat_deg, part.lon_deg, part.amsl_m, times[track.boot == boot]
        for lat_deg, lon_deg, amsl, time in zip(*columns, strict=True):
            point = _point(segment, "trkpt", lat_deg, lon_deg, amsl)
            if time:
                _child(point, "time", str(time))


def _point(parent: Xml.Element, tag: str, lat_deg: float, lon_deg: float, height_m: float) -> Xml.Element:
    # GPX longitudes end below 180: the antimeridian is -180.
    lon = -180.0 if lon_deg == 180 else lon_deg
    point = Xml.SubElement(parent, tag, lat=f"{lat_deg:.8f}", lon=f"{lon:.8f}")
    if math.isfinite(height_m):
        _child(point, "ele", f"{height_m:.3f}")
    return point


def _child(parent: Xml.Element, tag: str, content: str) -> None:
    Xml.SubElement(parent, tag).text = content

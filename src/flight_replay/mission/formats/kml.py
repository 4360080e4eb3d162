"""KML 2.2 (OGC 07-147r2): the mission as pins and a line, recorded and flown tracks as lines.

Altitudes are above mean sea level where that is known, of tracks as of home, else above ground, as if the
ground were level; what has neither lies on the ground. What KML has no word for (command, parameters,
speed) stands in ExtendedData.
"""

from __future__ import annotations

import math
from xml.etree import ElementTree as Xml

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.track import Track
from flight_replay.logs.tracks.kml_elements import OUR_FLOWN_TRACK, OUR_HOME, OUR_TRACK
from flight_replay.mission.formats.item_text import (
    amsl_m,
    command_name,
    description,
    route_line,
    speeds_m_s,
    utc_texts,
)
from flight_replay.mission.formats.validation import finite
from flight_replay.mission.items import Home, Mission, MissionItem

_NAMESPACE = "http://www.opengis.net/kml/2.2"
_GOOGLE = "http://www.google.com/kml/ext/2.2"
# aabbggrr: colours that the colour-blind tell apart (Okabe and Ito), those of the plots.
_STYLES = {"recorded": "ff999999", "planned": "ffb27200", "flown": "ff005ed5"}


def text(
    mission: Mission,
    track: Track | None = None,
    start_utc_s: float | None = None,
    flown: Track | None = None,
    outline: Mission | None = None,
) -> str:
    """The mission, or the outline of what is followed without one, the recorded track and what was flown.

    Tracks are lines; with ``start_utc_s``, the Unix time of the recorded track's first fix, they are there
    once more with times (gx:Track), which Google Earth plays side by side: the clock of ``flown`` is 0 at
    that fix.
    """
    root = Xml.Element("kml", {"xmlns": _NAMESPACE, "xmlns:gx": _GOOGLE})
    document = Xml.SubElement(root, "Document")
    _child(document, "name", "Flight replay")
    for name, colour in _STYLES.items():
        line_style = Xml.SubElement(Xml.SubElement(document, "Style", id=name), "LineStyle")
        _child(line_style, "color", colour)
        _child(line_style, "width", "3")
    folder = Xml.SubElement(document, "Folder")
    _child(folder, "name", "Mission")
    _add_mission(folder, mission)
    _add_route(folder, outline or mission)
    if track is not None and len(track):
        mode, heights_m = _track_heights(track)
        line = np.column_stack([track.lat_deg, track.lon_deg, heights_m])
        _add_line(document, OUR_TRACK, "recorded", mode, line)
        if start_utc_s is not None:
            _add_timed_track(document, "recorded", utc_texts(track, start_utc_s), mode, line)
    if flown is not None and len(flown):
        _add_flown(document, mission.home, flown, start_utc_s)
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _add_mission(folder: Xml.Element, mission: Mission) -> None:
    if mission.home is not None:
        home = mission.home
        pin = _pin(folder, OUR_HOME, "where the vehicle returns to")
        mode = "clampToGround" if home.alt_amsl_m is None else "absolute"
        _add_point(pin, mode, home.lat_deg, home.lon_deg, home.alt_amsl_m or 0.0)
    speeds = speeds_m_s(mission)
    for seq, item in mission.waypoints:
        pin = _pin(folder, str(seq), description(item))
        _add_data(pin, seq, item, speeds.get(seq))
        mode, height_m = _height(item, mission.home)
        _add_point(pin, mode, item.lat_deg, item.lon_deg, height_m)


def _add_route(folder: Xml.Element, mission: Mission) -> None:
    line, above_sea = route_line(mission)
    if len(line) > 1:
        mode = "absolute" if above_sea else "relativeToGround"
        _add_line(folder, "Route", "planned", mode, line)


def _add_flown(document: Xml.Element, home: Home | None, flown: Track, start_utc_s: float | None) -> None:
    """What was flown, which vehicles report above home."""
    ground_m = None if home is None else home.alt_amsl_m
    mode = "relativeToGround" if ground_m is None else "absolute"
    line = np.column_stack([flown.lat_deg, flown.lon_deg, flown.alt_m + (ground_m or 0.0)])
    _add_line(document, OUR_FLOWN_TRACK, "flown", mode, line)
    if start_utc_s is not None:
        times = utc_texts(flown, start_utc_s + float(flown.time_s[0]))
        _add_timed_track(document, "flown", times, mode, line)


def _track_heights(track: Track) -> tuple[str, Floats]:
    """Their mode and the heights (n,) of a recorded track; unknown ones between those of their neighbours."""
    for mode, heights_m in (("absolute", track.amsl_m), ("relativeToGround", track.alt_m)):
        known = np.flatnonzero(np.isfinite(heights_m))
        if len(known):
            return mode, np.interp(np.arange(len(track)), known, heights_m[known])
    return "clampToGround", np.zeros(len(track))


def _height(item: MissionItem, home: Home | None) -> tuple[str, float]:
    height_m = amsl_m(item, home)
    return ("absolute", height_m) if math.isfinite(height_m) else ("relativeToGround", item.alt_m)


def _pin(folder: Xml.Element, name: str, description: str) -> Xml.Element:
    pin = Xml.SubElement(folder, "Placemark")
    _child(pin, "name", name)
    _child(pin, "description", description)
    return pin


def _add_data(pin: Xml.Element, seq: int, item: MissionItem, speed_m_s: float | None) -> None:
    values: dict[str, object] = {"seq": seq, "command": int(item.command), "command_name": command_name(item)}
    values |= {"frame": int(item.frame), "alt_m": item.alt_m, "hold_s": item.hold_s}
    if speed_m_s is not None:
        values["speed_m_s"] = speed_m_s
    extended = Xml.SubElement(pin, "ExtendedData")
    for name, value in values.items():
        _child(Xml.SubElement(extended, "Data", name=name), "value", str(value))


def _add_point(pin: Xml.Element, mode: str, lat_deg: float, lon_deg: float, height_m: float) -> None:
    point = Xml.SubElement(pin, "Point")
    _child(point, "altitudeMode", mode)
    _child(point, "coordinates", _coordinates(lat_deg, lon_deg, height_m))


def _add_line(parent: Xml.Element, name: str, style: str, mode: str, places: Floats) -> None:
    line = Xml.SubElement(parent, "Placemark")
    _child(line, "name", name)
    _child(line, "styleUrl", f"#{style}")
    geometry = Xml.SubElement(line, "LineString")
    _child(geometry, "altitudeMode", mode)
    _child(geometry, "coordinates", "\n".join(_coordinates(*place) for place in places))


def _add_timed_track(parent: Xml.Element, style: str, times: list[str], mode: str, places: Floats) -> None:
    placemark = Xml.SubElement(parent, "Placemark")
    _child(placemark, "name", OUR_FLOWN_TRACK if style == "flown" else "Recorded flight")
    _child(placemark, "styleUrl", f"#{style}")
    track = Xml.SubElement(placemark, "gx:Track")
    _child(track, "altitudeMode", mode)
    for time in times:
        _child(track, "when", time)
    for place in places:
        _child(track, "gx:coord", _coordinates(*place).replace(",", " "))


def _coordinates(lat_deg: float, lon_deg: float, height_m: float) -> str:
    return f"{lon_deg:.8f},{lat_deg:.8f},{finite(height_m):.3f}"


def _child(parent: Xml.Element, tag: str, content: str) -> None:
    Xml.SubElement(parent, tag).text = content

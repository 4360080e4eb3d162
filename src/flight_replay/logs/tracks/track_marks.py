"""How the files of tracks begin; each function looks at the first 4096 bytes of one."""

from __future__ import annotations

import io
import re

from flight_replay.logs.tracks.byte_pieces import text_of
from flight_replay.logs.tracks.text_values import DELIMITERS, header_cells

_BEFORE_ROOT = re.compile(
    r"\s+|<\?.*?\?>|<!--.*?-->|<!DOCTYPE\s+(?P<type>[\w:.-]+)[^>\[]*(?:\[.*?\]\s*)?>", re.S
)
_OPEN_DOCTYPE = re.compile(r"<!DOCTYPE\s+(?P<type>[\w:.-]+)")
_ROOT = re.compile(r"<(?P<name>[\w:.-]+)[\s/>]")
_OF_GEOJSON = re.compile(
    r'"type"\s*:\s*"(FeatureCollection|Feature|LineString|MultiLineString)"|"(features|geometry|coordinates)"\s*:'
)
"""Members of an object come in any order, and the coordinates may be long."""
_ZIP = b"PK\x03\x04"
_DJI_VERSIONS = range(1, 40)
_DJI_HEADER = range(12, 1 << 31)


def begins_gpx(head: bytes) -> bool:
    """Whether it is a GPX file."""
    return _xml_root(head) == "gpx"


def begins_kml(head: bytes) -> bool:
    """Whether it is a KML file."""
    return _xml_root(head) == "kml"


def begins_zip(head: bytes) -> bool:
    """Whether it is a ZIP archive."""
    return head.startswith(_ZIP)


def begins_geojson(head: bytes) -> bool:
    """Whether it is a GeoJSON object."""
    text = text_of(head).lstrip() if b"{" in head[:64] else ""
    return text.startswith("{") and _OF_GEOJSON.search(text) is not None


def begins_saved_csv(head: bytes) -> bool:
    """Whether it is a table that ``--save FILE.csv`` wrote."""
    return header_of(head)[:1] == ["kind"] and {"lat_deg", "lon_deg", "time_s"} <= set(header_of(head))


def begins_airdata(head: bytes) -> bool:
    """Whether it is a table of AirData."""
    return {"latitude", "longitude", "time(millisecond)"} <= set(header_of(head))


def begins_dji_csv(head: bytes) -> bool:
    """Whether it is a table of DJI CsvView or PhantomHelp."""
    return {"OSD.latitude", "OSD.longitude"} <= set(header_of(head))


def begins_dji_record(head: bytes) -> bool:
    """Whether it is a flight record of DJI's apps, whose header is in none of their documents.

    It holds where the details are (8 bytes), how long they are (2), and the version (1), then zeros.
    """
    details, version = int.from_bytes(head[:8], "little"), head[10] if len(head) > 10 else 0
    return details in _DJI_HEADER and version in _DJI_VERSIONS and head[11:16] == bytes(5)


def header_of(head: bytes) -> list[str]:
    """The names of a table's columns."""
    if not any(each.encode() in head for each in DELIMITERS):
        return []
    return header_cells(line.rstrip("\n") for line in io.StringIO(text_of(head), newline=None))[0]


def _xml_root(head: bytes) -> str | None:
    """The name of an XML file's first element, or of the document type that it declares."""
    if b"<" not in head[:1024]:
        return None
    text, at = text_of(head), 0
    while match := _BEFORE_ROOT.match(text, at):
        if match["type"] in ("gpx", "kml"):
            return match["type"]
        at = match.end()
    root = _ROOT.match(text, at)
    if root:
        return root["name"].rpartition(":")[2]
    doctype = _OPEN_DOCTYPE.match(text, at)
    return doctype["type"] if doctype else None

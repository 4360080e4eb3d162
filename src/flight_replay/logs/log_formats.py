"""The formats of logs that can be read, each found by what a file holds, never by its name.

A new format is a folder with one function that is a ``Read``, and a line in ``FORMATS``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import cast

from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.dataflash.dataflash_marks import begins_dataflash, begins_dataflash_text
from flight_replay.logs.recording import Recording
from flight_replay.logs.tracks import track_marks
from flight_replay.logs.vehicles import VehicleId

Read = Callable[[OpenLog, VehicleId | None, Progress | None], Recording]
"""Reads the usable fixes of the vehicle that wrote a log, or of one of several: by default that with most.

It raises ``LogError`` where there is nothing usable. The recording's ``format`` is the table's to tell.
"""


@dataclass(frozen=True, slots=True)
class LogFormat:
    """A format: its ``name`` in JSON, its ``title`` for people, and how its files begin."""

    name: str
    title: str
    begins: Callable[[bytes], bool]
    read: Read


def recognised(log: OpenLog) -> LogFormat:
    """The format of a log; what no other claims is taken for a telemetry log, which has no first bytes."""
    return next((each for each in FORMATS if each.begins(log.head)), TELEMETRY_LOG)


def format_title(name: str) -> str:
    """The title of the format of that name."""
    return next(each.title for each in (*FORMATS, TELEMETRY_LOG) if each.name == name)


def _reader(module: str, function: str) -> Read:
    """A reader by its module in ``logs``, imported when a log is read: most runs need one of them."""

    def read(log: OpenLog, vehicle: VehicleId | None, progress: Progress | None) -> Recording:
        reader = getattr(import_module(f"flight_replay.logs.{module}"), function)
        return cast(Read, reader)(log, vehicle, progress)

    return read


FORMATS: tuple[LogFormat, ...] = (
    LogFormat(
        "dataflash", "DataFlash log", begins_dataflash, _reader("dataflash.read_bin", "read_dataflash")
    ),
    LogFormat(
        "dataflash-text",
        "DataFlash log",
        begins_dataflash_text,
        _reader("dataflash.read_text_log", "read_dataflash_text"),
    ),
    LogFormat(
        "ulog",
        "ULog",
        lambda head: head.startswith(b"ULog\x01\x12\x35"),
        _reader("ulog.ulog_reader", "read_ulog"),
    ),
    LogFormat("gpx", "GPX", track_marks.begins_gpx, _reader("tracks.gpx_reader", "read_gpx")),
    LogFormat("kml", "KML", track_marks.begins_kml, _reader("tracks.kml_reader", "read_kml")),
    LogFormat("kmz", "KMZ", track_marks.begins_zip, _reader("tracks.kml_reader", "read_kmz")),
    LogFormat(
        "geojson", "GeoJSON", track_marks.begins_geojson, _reader("tracks.geojson_reader", "read_geojson")
    ),
    LogFormat("csv", "CSV", track_marks.begins_saved_csv, _reader("tracks.saved_csv", "read_saved_csv")),
    LogFormat(
        "airdata", "AirData CSV", track_marks.begins_airdata, _reader("tracks.dji_csv", "read_airdata")
    ),
    LogFormat("dji-csv", "DJI CSV", track_marks.begins_dji_csv, _reader("tracks.dji_csv", "read_dji_csv")),
    LogFormat(
        "dji-txt",
        "DJI flight record",
        track_marks.begins_dji_record,
        _reader("tracks.dji_record", "read_dji_record"),
    ),
)
"""All formats that have marks of their own, the surest first."""

TELEMETRY_LOG = LogFormat("tlog", "tlog", lambda _head: True, _reader("tlog.reader", "read_tlog"))

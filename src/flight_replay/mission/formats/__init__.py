"""Missions and tracks to and from the files that other programs read, chosen by suffix.

| suffix | program | holds |
| --- | --- | --- |
| .waypoints | Mission Planner, MAVProxy, QGroundControl | mission and home; read back |
| .plan | QGroundControl | mission and home; read back |
| .kml | Google Earth, Mission Planner | mission and track |
| .gpx | GPSBabel, maps, watches | mission as a route, and track |
| .geojson | QGIS, geojson.io, web maps | mission and track |
| .csv | spreadsheets, pandas | mission and track |
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from flight_replay import atomic_write
from flight_replay.errors import MissionError
from flight_replay.logs.track import Track
from flight_replay.mission.formats import csv_table, geojson, gpx, kml, qgc_plan, wpl
from flight_replay.mission.items import Mission

_WRITERS: dict[str, Callable[[Mission, Track | None], str]] = {
    ".waypoints": wpl.text,
    ".plan": qgc_plan.text,
    ".kml": kml.text,
    ".gpx": gpx.text,
    ".geojson": geojson.text,
    ".csv": csv_table.text,
}
_READERS: dict[str, Callable[[str, str], Mission]] = {
    ".waypoints": wpl.parse,
    ".plan": qgc_plan.parse,
}

SAVED_SUFFIXES = tuple(_WRITERS)
LOADED_SUFFIXES = tuple(_READERS)


def check_suffix(path: Path | str) -> str:
    """The suffix of a file to be saved, in lower case; raises MissionError when no format has it."""
    return _known(path, SAVED_SUFFIXES, "write")


def save(path: Path | str, mission: Mission, track: Track | None = None) -> None:
    """Write a mission, and the recorded track where the format holds one; replaces the file whole.

    Raises:
        MissionError: No format has this suffix.
        FlightReplayError: The file cannot be written.
    """
    atomic_write.write(path, _WRITERS[check_suffix(path)](mission, track))


def load_mission(path: Path | str) -> Mission:
    """Read a mission that this or another program wrote.

    Raises:
        MissionError: No format has this suffix, or the file cannot be read or understood.
    """
    reader = _READERS[_known(path, LOADED_SUFFIXES, "read")]
    try:
        # Mission Planner writes CRLF lines, some editors a byte order mark.
        text = Path(path).expanduser().read_text(encoding="utf-8-sig")
    except OSError as error:
        raise MissionError(f"cannot read {path}: {error.strerror}; give a mission file") from error
    except UnicodeDecodeError as error:
        raise MissionError(f"{path} is not text; give a mission file") from error
    return reader(text, str(path))


def _known(path: Path | str, suffixes: tuple[str, ...], verb: str) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes:
        named = f'suffix "{suffix}"' if suffix else "no suffix"
        raise MissionError(f"cannot {verb} {path}: {named}; use one of {', '.join(suffixes)}")
    return suffix

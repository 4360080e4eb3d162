"""Missions and tracks to and from the files that other programs read, chosen by suffix.

| suffix | program | holds |
| --- | --- | --- |
| .waypoints | Mission Planner, MAVProxy, QGroundControl | mission and home; read back |
| .plan | QGroundControl | mission and home; read back |
| .kml | Google Earth, Mission Planner | mission, track, and the flown track |
| .gpx | GPSBabel, maps, watches | mission as a route, and track |
| .geojson | QGIS, geojson.io, web maps | mission and track |
| .csv | spreadsheets, pandas | mission and track |
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from flight_replay.exceptions import MissionError
from flight_replay.logs.track import Track
from flight_replay.mission.formats import csv_table, geojson, gpx, kml, qgc_plan, wpl
from flight_replay.mission.formats.validation import checked_length
from flight_replay.mission.items import Mission
from flight_replay.writing.output_files import check_suffix, write_atomically

_WRITERS: dict[str, Callable[[Mission, Track | None, float | None], str]] = {
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
FLOWN_SUFFIXES = (".kml",)
"""Those that hold what was flown, and what is followed, beside what was recorded."""


def save(  # noqa: PLR0913
    path: Path | str,
    mission: Mission,
    track: Track | None = None,
    start_utc_s: float | None = None,
    flown: Track | None = None,
    *,
    outline: Mission | None = None,
) -> None:
    """Write a mission, and the recorded track where the format holds one; replaces the file whole.

    Args:
        path: The file, whose suffix chooses the format.
        mission: What to write.
        track: The recorded track.
        start_utc_s: Unix time of the track's first fix, for formats whose times are those of the day.
        flown: What was flown, in formats of ``FLOWN_SUFFIXES``; its clock is 0 at the track's first fix.
        outline: What is followed in GUIDED without a mission, in formats of ``FLOWN_SUFFIXES``: as a line.

    Raises:
        FlightReplayError: No format has this suffix, or the file cannot be written.
    """
    suffix = check_suffix(path, SAVED_SUFFIXES)
    if suffix == ".kml":
        text = kml.text(mission, track, start_utc_s, flown, outline)
    else:
        text = _WRITERS[suffix](mission, track, start_utc_s)
    write_atomically(path, text)


def load_mission(path: Path | str) -> Mission:
    """Read a mission that this or another program wrote.

    Raises:
        FlightReplayError: No format has this suffix.
        MissionError: The file cannot be read, or is not a mission.
    """
    reader = _READERS[check_suffix(path, LOADED_SUFFIXES)]
    try:
        # Mission Planner writes CRLF lines, some editors a byte order mark.
        text = Path(path).expanduser().read_text(encoding="utf-8-sig")
    except OSError as error:
        raise MissionError(f"cannot read {path}: {error.strerror}; give a mission file") from error
    except UnicodeDecodeError as error:
        raise MissionError(f"{path} is not text; give a mission file") from error
    return checked_length(reader(text, str(path)), str(path))

"""Tables of DJI flights: AirData's, and those of DJI CsvView and PhantomHelp.

Units stand in the columns' names. The aircraft's x, y and z axes are north, east and down; heights are
above where it took off. DJI's apps record while the motors run.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Floats
from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import Armed
from flight_replay.logs.tracks.byte_pieces import LogPieces
from flight_replay.logs.tracks.point_times import spread_repeats
from flight_replay.logs.tracks.recorded_columns import columns_recording
from flight_replay.logs.tracks.table_rows import Table, as_number
from flight_replay.logs.tracks.text_values import unix_time_s
from flight_replay.logs.tracks.track_recording import TrackFile
from flight_replay.logs.vehicles import VehicleId

_UNITS = {
    "": 1.0,
    "m": 1.0,
    "meters": 1.0,
    "metres": 1.0,
    "ft": 0.3048,
    "feet": 0.3048,
    "m/s": 1.0,
    "mph": 0.44704,
    "km/h": 1 / 3.6,
    "kmh": 1 / 3.6,
    "kph": 1 / 3.6,
    "knots": 1852 / 3600,
    "kn": 1852 / 3600,
    "s": 1.0,
    "millisecond": 1e-3,
    "ms": 1e-3,
    "degrees": 1.0,
    "°": 1.0,
    "360": 1.0,
}
_NAMED = re.compile(r"(?P<name>[^(\[]*?)\s*(?:[(\[](?P<unit>[^)\]]*)[)\]])?\s*")
_MINUTES = re.compile(r"(?:(\d+)m\s*)?(\d+(?:\.\d+)?)s")


@dataclass(frozen=True, slots=True)
class _Dialect:
    """A program's table: the columns of each of a track's, of which the first that there is is read.

    And the one with dates, and that of the motors, if there are such.
    """

    columns: Mapping[str, Sequence[str]]
    utc: str | None = None
    motors: str | None = None


_AIRDATA = _Dialect(
    {
        "time_s": ("time",),
        "lat_deg": ("latitude",),
        "lon_deg": ("longitude",),
        "alt_m": ("height_above_takeoff", "ascent"),
        "amsl_m": ("altitude_above_seaLevel", "altitude"),
        "north_m_s": ("xSpeed",),
        "east_m_s": ("ySpeed",),
        "down_m_s": ("zSpeed",),
        "heading_deg": ("compass_heading",),
    },
    utc="datetime",
)
_CSV_VIEW = _Dialect(
    {
        "time_s": ("OSD.flyTime",),
        "lat_deg": ("OSD.latitude",),
        "lon_deg": ("OSD.longitude",),
        "alt_m": ("OSD.height",),
        "north_m_s": ("OSD.xSpeed",),
        "east_m_s": ("OSD.ySpeed",),
        "down_m_s": ("OSD.zSpeed",),
        "heading_deg": ("OSD.yaw",),
    },
    motors="OSD.isMotorUp",
)


def read_airdata(log: OpenLog, _vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read a table of AirData; see ``log_formats.Read``."""
    return _read(log, progress, _AIRDATA)


def read_dji_csv(log: OpenLog, _vehicle: VehicleId | None, progress: Progress | None) -> Recording:
    """Read a table of DJI CsvView or PhantomHelp; see ``log_formats.Read``."""
    return _read(log, progress, _CSV_VIEW)


def _read(log: OpenLog, progress: Progress | None, dialect: _Dialect) -> Recording:
    pieces = LogPieces(log, progress)
    table = Table(pieces, log.name)
    columns = table.columns(_wanted(table.header, dialect, log.name))
    utc_s = columns.pop("utc_s", None)
    armed = columns.get("armed", np.ones(0))
    columns["armed"] = armed if len(armed) else np.full(len(columns["lat_deg"]), float(Armed.YES))
    if "down_m_s" in columns:
        columns["up_m_s"] = 0.0 - columns.pop("down_m_s")
    if "time_s" in columns:
        order = np.argsort(columns["time_s"], kind="stable")
        columns = {name: column[order] for name, column in columns.items()}
        columns["time_s"] = _spread(columns["time_s"])
        utc_s = None if utc_s is None else utc_s[order]
    file = TrackFile(name=log.name, bytes=pieces.count, notes=table.notes)
    return columns_recording(columns, file, utc_s)


def _spread(time_s: Floats) -> Floats:
    """Times (n,) in order, those repeated spread evenly, unknown ones at the end."""
    known = np.count_nonzero(np.isfinite(time_s))
    return np.concatenate([spread_repeats(time_s[:known]), time_s[known:]])


def _wanted(
    header: Sequence[str], dialect: _Dialect, name: str
) -> dict[str, tuple[str, Callable[[str], float]]]:
    """Which columns to read, and how.

    Raises:
        LogError: One of them is in a unit that is not known.
    """
    titles: dict[str, tuple[str, str]] = {}
    for title in header:
        if match := _NAMED.fullmatch(title):
            titles.setdefault(match["name"].strip(), (title, (match["unit"] or "").strip().lower()))
    wanted: dict[str, tuple[str, Callable[[str], float]]] = {}
    for column, names in dialect.columns.items():
        known = [titles[each] for each in names if each in titles]
        for title, unit in known[:1]:
            wanted[column] = (title, _reader(_factor(title, unit, name)))
    if dialect.utc in titles:
        wanted["utc_s"] = (titles[dialect.utc][0], unix_time_s)
    if dialect.motors in titles:
        wanted["armed"] = (titles[dialect.motors][0], _motors)
    return wanted


def _factor(title: str, unit: str, name: str) -> float:
    if unit not in _UNITS:
        raise LogError(f"{name} has {title} in a unit that is not known; export it in metric units")
    return _UNITS[unit]


def _reader(factor: float) -> Callable[[str], float]:
    """A function that reads a cell in a unit of so many SI units; times may be as "1m 2.5s"."""

    def read(cell: str) -> float:
        match = _MINUTES.fullmatch(cell.strip())
        if match:
            return 60.0 * int(match[1] or 0) + float(match[2])
        return factor * as_number(cell)

    return read


def _motors(cell: str) -> float:
    """Whether the motors run, as ``Armed``."""
    return float(
        {"true": Armed.YES, "1": Armed.YES, "false": Armed.NO, "0": Armed.NO}.get(
            cell.strip().lower(), Armed.UNKNOWN
        )
    )

"""From columns of a table, named as those of a track, to a recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.logs.derived_velocity import with_derived_velocity
from flight_replay.logs.heights_above_home import with_heights_above_home
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import Armed, Track, track_from_columns
from flight_replay.logs.tracks.point_times import are_times
from flight_replay.logs.tracks.track_points import TrackPoints
from flight_replay.logs.tracks.track_recording import (
    TrackFile,
    boots_from_0,
    nothing_usable,
    plausible_heights_m,
    track_recording,
)
from flight_replay.logs.usable_fixes import usable_fixes

_FASTEST_M_S = 150.0
"""No multicopter is faster; who says so is not believed how far it got."""
_MOST_BOOTS = 10_000


def columns_recording(columns: Mapping[str, Floats], file: TrackFile, utc_s: Floats | None) -> Recording:
    """The recording of columns (n,); what is missing or not a number is unknown.

    Args:
        columns: Values by the names that ``Track`` has for them; latitude and longitude at least.
        file: Where they were read.
        utc_s: The Unix times of the rows (n,), where they have some.

    Raises:
        LogError: None of the positions is usable.
    """
    n = len(columns["lat_deg"])
    unknown = np.full(n, np.nan)
    known = {name: np.asarray(columns.get(name, unknown), float) for name in _FLOATS}
    boot = _boots(columns.get("boot", unknown))
    time_s = known["time_s"]
    if not are_times(time_s):
        return track_recording(_points(known, boot), file)
    order = np.argsort(time_s, kind="stable")[: np.count_nonzero(np.isfinite(time_s))]
    track = _track(known, boot, columns.get("armed", unknown)).select(order)
    usable = usable_fixes(replace(track, boot=np.maximum.accumulate(track.boot)))
    if not len(usable.track):
        raise LogError(nothing_usable(file, usable.why_none()))
    track = replace(usable.track, boot=boots_from_0(usable.track.boot))
    utc = [] if utc_s is None else utc_s[order][time_s[order] >= usable.track.time_s[0]][:1]
    return Recording(
        path=file.name,
        bytes=file.bytes,
        track=with_heights_above_home(with_derived_velocity(track)),
        without_position=usable.without_position,
        rejected=usable.rejected,
        start_utc_s=float(utc[0]) if len(utc) and np.isfinite(utc[0]) else None,
        notes=tuple(file.notes),
    )


_FLOATS = (
    "time_s",
    "lat_deg",
    "lon_deg",
    "alt_m",
    "amsl_m",
    "north_m_s",
    "east_m_s",
    "up_m_s",
    "heading_deg",
)


def _boots(boot: Floats) -> Indices:
    """Numbers of boots (n,), 0 where unknown."""
    is_one = (boot >= 0) & (boot < _MOST_BOOTS)
    return np.where(is_one, boot, 0.0).astype(np.intp)


def _track(known: Mapping[str, Floats], boot: Indices, armed: Floats) -> Track:
    """All rows as fixes, in their order."""
    velocity = np.column_stack([known[name] for name in ("north_m_s", "east_m_s", "up_m_s")])
    velocity[~(np.abs(velocity) <= _FASTEST_M_S)] = np.nan
    states = np.where(np.isin(armed, list(Armed)), armed, Armed.UNKNOWN)
    time_s = known["time_s"]
    return track_from_columns(
        time_s,
        known["lat_deg"],
        known["lon_deg"],
        plausible_heights_m(known["alt_m"], time_s),
        amsl_m=plausible_heights_m(known["amsl_m"], time_s),
        velocity_m_s=velocity,
        heading_deg=known["heading_deg"] % 360.0,
        boot=boot.astype(np.int32),
        armed=states.astype(np.int8),
    )


def _points(known: Mapping[str, Floats], boot: Indices) -> TrackPoints:
    """Rows without times; each boot is a track."""
    columns = {name: known[name] for name in ("lat_deg", "lon_deg", "alt_m", "amsl_m", "heading_deg")}
    unknown = np.full(len(boot), np.nan)
    return TrackPoints(
        **columns, utc_s=unknown, north_m_s=unknown, east_m_s=unknown, track=boot, segment=boot
    )

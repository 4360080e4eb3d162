"""From the points of a track to a recording: plausible ones, with velocities and heights above home."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Floats
from flight_replay.logs.derived_velocity import with_derived_velocity
from flight_replay.logs.flights import find_flights
from flight_replay.logs.heights_above_home import with_heights_above_home
from flight_replay.logs.plausibility import FASTEST_M_S
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import UNTIMED_SPEED_M_S, Armed, Track, track_from_columns
from flight_replay.logs.tracks.point_times import (
    OrderedPoints,
    are_timed,
    in_order_of_file,
    in_order_of_time,
)
from flight_replay.logs.tracks.track_points import TrackPoints
from flight_replay.logs.usable_fixes import UsableFixes, usable_fixes

_LONGEST_STEP_M = 10_000.0
"""Points of an untimed line that are farther apart are no flight of a multicopter."""
_LOWEST_M, _HIGHEST_M = -500.0, 20_000.0
_HEIGHT_SLACK_M, _STEEPEST_M_S = 50.0, 30.0
"""A height that no multicopter can have climbed to from the ones beside it, nor descended from."""
_AROUND = 5
_LONGEST_CLIMB_S = 10.0
"""From point to point of a line without times."""
_LAST_UTC_S = 4e9  # 2096
_SLIGHTLY_OFF_M_S, _OFF = 0.5, 0.25
"""Recorded velocities may differ by so much, or by this part of the speed, from those of the positions."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackFile:
    """The file that a track was read from: its name, its bytes, and notes on how it was read.

    ``home_amsl_m`` is home's height above the sea where the file tells it, else not a number.
    """

    name: str
    bytes: int
    notes: Sequence[str] = ()
    home_amsl_m: float = math.nan


def track_recording(points: TrackPoints, file: TrackFile) -> Recording:
    """The recording of a track's points.

    Raises:
        LogError: None of them is usable.
    """
    if not len(points):
        raise LogError(nothing_usable(file, "it holds no track"))
    timed = are_timed(points)
    ordered = in_order_of_time(points) if timed else in_order_of_file(points)
    usable = _judged(ordered, timed=timed)
    if not len(usable.track):
        raise LogError(nothing_usable(file, usable.why_none()))
    track = _timed(usable.track) if timed else _untimed(usable.track)
    above_home = with_heights_above_home(track, file.home_amsl_m)
    first_s = float(usable.track.time_s[0])
    notes = [*file.notes, *ordered.notes]
    if not timed:
        notes.append("It has no times: only its line can be replayed")
    else:
        notes += _heights_from_the_air(track, above_home)
    return Recording(
        path=file.name,
        bytes=file.bytes,
        track=above_home,
        without_position=usable.without_position,
        rejected=usable.rejected,
        start_utc_s=first_s if timed and 0 < first_s < _LAST_UTC_S else None,
        notes=tuple(notes),
    )


def _heights_from_the_air(track: Track, above_home: Track) -> list[str]:
    """What is said of boots that begin with a flight, whose first fix got them their heights above home."""
    flights = find_flights(above_home)
    from_first = np.isnan(track.alt_m) & (above_home.alt_m == 0) & (np.diff(track.boot, prepend=-1) != 0)
    boots = {int(track.boot[flight.first]) for flight in flights if from_first[flight.first]}
    count = sum(int(track.boot[flight.first]) in boots for flight in flights)
    if not count:
        return []
    which = "Its heights" if count == len(flights) else f"Heights of {count} of its {len(flights)} flights"
    return [
        f"{which} count from a first fix that moves: if that was in the air, they are too low; "
        "raise them with --altitude recorded+M"
    ]


def nothing_usable(file: TrackFile, why: str) -> str:
    """What is said of a file without a usable position."""
    notes = [note[0].lower() + note[1:] for note in file.notes]
    return "; ".join([f"{file.name} has no usable position: {why}", *notes, "name another log"])


def _judged(ordered: OrderedPoints, *, timed: bool) -> UsableFixes:
    """The plausible points, their times still Unix times, their heights above home as the file tells."""
    points = ordered.points
    by_index_s = np.arange(len(points)) * (_LONGEST_STEP_M / FASTEST_M_S)
    time_s = np.asarray(points.utc_s if timed else by_index_s, float)
    climbing_s = np.asarray(time_s if timed else np.arange(len(points)) * _LONGEST_CLIMB_S, float)
    track = track_from_columns(
        time_s,
        points.lat_deg,
        points.lon_deg,
        plausible_heights_m(points.alt_m, climbing_s),
        amsl_m=plausible_heights_m(points.amsl_m, climbing_s),
        velocity_m_s=_velocity_m_s(points) if timed else None,
        heading_deg=points.heading_deg % 360.0,
        boot=ordered.boot,
    )
    return usable_fixes(track)


def _velocity_m_s(points: TrackPoints) -> Floats:
    """Velocities north, east and up (n, 3), of which files tell the first two at most."""
    velocity = np.column_stack([points.north_m_s, points.east_m_s, np.full(len(points), np.nan)])
    velocity[~(np.hypot(*velocity.T[:2]) <= FASTEST_M_S)] = np.nan
    return velocity


def _timed(track: Track) -> Track:
    """The track with its clock from 0, and with velocities."""
    track = replace(track, time_s=track.time_s - track.time_s[0], boot=boots_from_0(track.boot))
    climbing = replace(track, alt_m=np.where(np.isfinite(track.alt_m), track.alt_m, track.amsl_m))
    moving = with_derived_velocity(_without_wrong_velocity(climbing))
    return replace(moving, alt_m=track.alt_m)


def _without_wrong_velocity(track: Track) -> Track:
    """The track without its recorded velocities if its positions tell others: some programs write km/h."""
    unknown = np.full(len(track), np.nan)
    bare = replace(track, north_m_s=unknown, east_m_s=unknown)
    derived = with_derived_velocity(bare)
    off_m_s = np.hypot(track.north_m_s - derived.north_m_s, track.east_m_s - derived.east_m_s)
    known = np.isfinite(off_m_s)
    if not known.any():
        return bare
    usual_m_s = float(np.median(np.hypot(derived.north_m_s, derived.east_m_s)[known]))
    return track if np.median(off_m_s[known]) <= max(_SLIGHTLY_OFF_M_S, _OFF * usual_m_s) else bare


def _untimed(track: Track) -> Track:
    """The track as flown at one speed, armed all along."""
    along_s = np.append(0.0, np.cumsum(track.steps_m)) / UNTIMED_SPEED_M_S
    armed = np.full(len(track), Armed.YES, np.int8)
    return replace(track, time_s=along_s, boot=boots_from_0(track.boot), armed=armed, timed=False)


def boots_from_0(boot: NDArray[np.int32]) -> NDArray[np.int32]:
    """Boots (n,) numbered from 0 without those of which nothing is left."""
    return np.unique(boot, return_inverse=True)[1].astype(np.int32)


def plausible_heights_m(height_m: Floats, time_s: Floats) -> Floats:
    """Heights (n,) at times (n,), those that no multicopter has been at not a number.

    One is implausible below the Dead Sea or above 20 km, and if the median of five around it is farther
    than a multicopter climbs.
    """
    heights_m: Floats = np.where((height_m >= _LOWEST_M) & (height_m <= _HIGHEST_M), height_m, np.nan)
    known = np.flatnonzero(np.isfinite(heights_m))
    if len(known) < _AROUND:
        return heights_m
    half = _AROUND // 2
    at = np.pad(known, half, mode="edge")
    around = sliding_window_view(at, _AROUND)
    reach_m = _HEIGHT_SLACK_M + _STEEPEST_M_S * (time_s[around[:, -1]] - time_s[around[:, 0]])
    off_m = np.abs(heights_m[known] - np.median(heights_m[around], axis=1))
    heights_m[known[off_m > reach_m]] = np.nan
    return heights_m

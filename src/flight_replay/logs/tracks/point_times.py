"""The order and the times of a track's points.

Files give whole seconds at several points a second, tracks newest first, the same flight twice, and
some points without a time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.geometry.geodesy import surface_xyz_m
from flight_replay.geometry.polyline import segment_lengths_m
from flight_replay.logs.tracks.track_points import TrackPoints
from flight_replay.writing.counted import counted

_SEGMENT_GAP_S = 10.0
"""Receivers begin a segment whenever they lost the satellites; after more than this, somebody switched on."""
_LONGEST_GAP_S = 86_400.0
"""After more than this the receiver had learned the date; nothing flies as long."""
_SEGMENT_GAP_M = 50.0
_COARSEST_S = 1.0
"""Clocks that repeat themselves mostly show whole seconds."""


@dataclass(frozen=True, slots=True, eq=False)
class OrderedPoints:
    """Points in the order of time with their boots (n,); ``notes`` say what was left out."""

    points: TrackPoints
    boot: NDArray[np.int32]
    notes: tuple[str, ...] = ()


def are_times(time_s: Floats) -> bool:
    """Whether most of some times (n,) are known, and not all the same but for a single one."""
    known = time_s[np.isfinite(time_s)]
    return 2 * len(known) > len(time_s) and (len(time_s) == 1 or bool(known.max() > known.min()))


def are_timed(points: TrackPoints) -> bool:
    """Whether most points of all, or of one of the tracks, have a time, and not all the same.

    A planned track may stand beside the flown one, and have more points.
    """
    if are_times(points.utc_s):
        return True
    begins = np.flatnonzero(np.diff(points.track, prepend=-1))
    lengths = np.diff(begins, append=len(points))
    known = np.add.reduceat(np.isfinite(points.utc_s), begins, dtype=np.intp)
    first_s, last_s = (end.reduceat(points.utc_s, begins) for end in (np.fmin, np.fmax))
    return bool(((2 * known > lengths) & (last_s > first_s)).any())


def in_order_of_time(points: TrackPoints) -> OrderedPoints:
    """Points that are timed, each at a time of its own."""
    known = np.isfinite(points.utc_s)
    untimed = int(np.count_nonzero(~known))
    notes = [f"Left out: {counted(untimed, 'point')} without a time"] if untimed else []
    points = points.select(known)
    apart = points.select(_apart_in_time(points))
    left_out = len(np.unique(points.track)) - len(np.unique(apart.track))
    if left_out:
        notes.append(f"Left out: {counted(left_out, 'track')} at the same time as a longer one")
    points = apart.select(np.argsort(apart.utc_s, kind="stable"))
    gap_s = np.diff(points.utc_s)
    breaks = (np.diff(points.segment) != 0) & (gap_s > _SEGMENT_GAP_S) | (gap_s > _LONGEST_GAP_S)
    spread = replace(points, utc_s=spread_repeats(points.utc_s))
    return OrderedPoints(spread, _numbered(breaks), tuple(notes))


def _apart_in_time(points: TrackPoints) -> Flags:
    """The points (n,) of tracks that were recorded one after another.

    Of tracks at the same time the one with most points is kept, but two that overlap by less than half of
    either: of those the one goes on where the other ends.
    """
    numbers, counts = np.unique(points.track, return_counts=True)
    keep = np.zeros(len(points), np.bool_)
    spans: list[tuple[float, float]] = []
    for number in numbers[np.argsort(-counts, kind="stable")]:
        own = np.flatnonzero(points.track == number)
        utc_s = points.utc_s[own]
        begin_s, end_s = float(utc_s.min()), float(utc_s.max())
        others = [(first_s, last_s) for first_s, last_s in spans if begin_s < last_s and end_s > first_s]
        if all(
            2 * (min(end_s, last_s) - max(begin_s, first_s)) < min(end_s - begin_s, last_s - first_s)
            for first_s, last_s in others
        ):
            spans.append((begin_s, end_s))
            keep[own] = True
            for first_s, last_s in others:
                keep[own[(utc_s >= first_s) & (utc_s <= last_s)]] = False
    return keep


def spread_repeats(time_s: Floats) -> Floats:
    """Times (n,) that never fall, repeated ones spread evenly up to the next, or over one clock step."""
    if len(time_s) < 2:
        return time_s
    first = np.flatnonzero(np.diff(time_s, prepend=-np.inf) > 0)
    count = np.diff(first, append=len(time_s))
    ahead_s = np.diff(time_s[first])
    usual_s = float(np.median(ahead_s)) if len(ahead_s) else _COARSEST_S
    step_s = np.minimum(np.append(ahead_s, min(usual_s, _COARSEST_S)), max(usual_s, _COARSEST_S))
    nth = np.arange(len(time_s)) - np.repeat(first, count)
    return np.asarray(time_s + nth * np.repeat(step_s / count, count))


def in_order_of_file(points: TrackPoints) -> OrderedPoints:
    """Points without times: segments that join are one part, a track is always one of its own."""
    is_far = segment_lengths_m(surface_xyz_m(points.lat_deg, points.lon_deg)) > _SEGMENT_GAP_M
    breaks = (np.diff(points.track) != 0) | (np.diff(points.segment) != 0) & is_far
    return OrderedPoints(points, _numbered(breaks))


def _numbered(breaks: Flags) -> NDArray[np.int32]:
    """Numbers from 0 (n,) of parts that begin behind breaks (n - 1,)."""
    return np.append(0, np.cumsum(breaks)).astype(np.int32)

"""The flights of a log: its armed stretches, or what moved in boots of which it tells nothing of arming."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.logs.track import Armed, Track

_MOVING_M_S = 0.5  # receivers at rest report less
_PAUSE_S = 10.0  # a copter that hovers for less is on the same flight
_HOVER_S, _HOVER_M = 300.0, 2.0
"""Nor does a longer pause end a flight, up to so long, if the vehicle is so far above home all the while.

Heights drift: of vehicles that stood disarmed they came below half a metre in each of 15 pauses of five logs.
"""
_SHORTEST_MOVE_S = 2.0


@dataclass(frozen=True, slots=True)
class Flight:
    """A flown stretch: the fixes ``first`` to ``last`` of the log's track, both of it.

    ``number`` counts from 1; ``start_s`` and ``end_s`` are seconds since the track's first fix;
    ``highest_m`` is above home, ``top_speed_m_s`` over ground, each None where the log has none.
    """

    number: int
    start_s: float
    end_s: float
    fixes: int
    length_m: float
    first: int
    last: int
    highest_m: float | None = None
    top_speed_m_s: float | None = None


def find_flights(track: Track) -> tuple[Flight, ...]:
    """The flights of a track, in order; one that spans a reboot is two."""
    flown = track.armed == Armed.YES
    told = np.isin(track.boot, np.unique(track.boot[track.armed != Armed.UNKNOWN]))
    if not told.all():
        flown |= _moving(track) & ~told
    along_m = np.append(0.0, np.cumsum(track.steps_m))
    return tuple(
        _flight(track, along_m, number, first, last)
        for number, (first, last) in enumerate(_stretches(track, flown), 1)
    )


def select(
    track: Track, flight: int | None = None, from_s: float | None = None, to_s: float | None = None
) -> Track:
    """The fixes of a flight, or of all the track, between two times.

    Args:
        track: The whole track of a log.
        flight: Number of a flight, from 1.
        from_s: First second wanted, counted from the first fix of the flight (or track).
        to_s: Last second wanted, counted likewise.

    Raises:
        LogError: There is no such flight, or no fix between those times.
    """
    if flight is not None:
        flights = find_flights(track)
        if not 1 <= flight <= len(flights):
            raise LogError(f"there is no flight {flight} in the log, {_there_are(len(flights))}")
        track = track.select(slice(flights[flight - 1].first, flights[flight - 1].last + 1))
    since_s = track.time_s - track.time_s[0]
    keep = np.ones(len(track), np.bool_)
    if from_s is not None:
        keep &= since_s >= from_s
    if to_s is not None:
        keep &= since_s <= to_s
    if not keep.any():
        raise LogError(f"no fix lies between --from and --to; {_times(since_s, from_s or 0.0)}")
    return track if keep.all() else track.select(keep)


def _times(since_s: Floats, from_s: float) -> str:
    """What can be chosen, by the fixes' times (n,): what is beside a gap that ``from_s`` lies in."""
    following = int(np.searchsorted(since_s, from_s))
    if not 0 < following < len(since_s):
        return f"choose from 0 to {since_s[-1]:.1f} s"
    last_s, next_s = since_s[following - 1], since_s[following]
    return f"the log has none from {last_s:.2f} to {next_s:.2f} s, choose times beside that"


def _there_are(count: int) -> str:
    """What can be chosen."""
    if count == 0:
        return "which holds none; leave out --flight"
    return "choose --flight 1" if count == 1 else f"choose --flight 1 to {count}"


def _stretches(track: Track, flown: Flags) -> list[tuple[int, int]]:
    """First and last index of each run of flown fixes within one boot."""
    index = np.flatnonzero(flown)
    if not len(index):
        return []
    breaks = np.flatnonzero((np.diff(index) > 1) | (np.diff(track.boot[index]) != 0))
    firsts = index[np.concatenate([[0], breaks + 1])]
    lasts = index[np.append(breaks, len(index) - 1)]
    return list(zip(firsts.tolist(), lasts.tolist(), strict=True))


def _moving(track: Track) -> Flags:
    """The fixes of stretches in which the vehicle moved, short pauses included."""
    known = (np.nan_to_num(axis) for axis in (track.north_m_s, track.east_m_s, track.up_m_s))
    speed_m_s = np.sqrt(sum(axis**2 for axis in known))
    flown = np.zeros(len(track), np.bool_)
    index = np.flatnonzero(speed_m_s > _MOVING_M_S)
    if not len(index):
        return flown
    still_s = np.diff(track.time_s[index])
    lowest_m = np.minimum.reduceat(np.append(track.alt_m, np.nan), index)[:-1]
    hovers = (still_s <= _HOVER_S) & (lowest_m > _HOVER_M)
    ends = ((still_s > _PAUSE_S) & ~hovers) | (np.diff(track.boot[index]) != 0)
    breaks = np.flatnonzero(ends)
    for begin, end in zip(np.r_[0, breaks + 1], np.r_[breaks, len(index) - 1], strict=True):
        if track.time_s[index[end]] - track.time_s[index[begin]] >= _SHORTEST_MOVE_S:
            flown[index[begin] : index[end] + 1] = True
    return flown


def _flight(track: Track, along_m: Floats, number: int, first: int, last: int) -> Flight:
    """A flight of the fixes ``first`` to ``last``; ``along_m`` is the distance along the track (n,)."""
    start_s, end_s = (float(track.time_s[end] - track.time_s[0]) for end in (first, last))
    length_m = float(along_m[last] - along_m[first])
    part = slice(first, last + 1)
    speed_m_s = np.hypot(track.north_m_s[part], track.east_m_s[part])
    highest_m, top_speed_m_s = _highest(track.alt_m[part]), _highest(speed_m_s)
    return Flight(number, start_s, end_s, last - first + 1, length_m, first, last, highest_m, top_speed_m_s)


def _highest(values: Floats) -> float | None:
    """The highest value that is a number."""
    known = values[np.isfinite(values)]
    return float(known.max()) if len(known) else None

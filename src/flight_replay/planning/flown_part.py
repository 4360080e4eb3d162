"""The part of a log that was flown: its flights joined in order, without the gaps between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.geodesy import distance_m
from flight_replay.logs.flights import Flight, find_flights
from flight_replay.logs.track import Track

MAX_GAP_M = 50.0
"""Flights that begin farther than this from where the last one ended are worth a note."""


def flown_part(track: Track, *, tell_joins: bool = True) -> tuple[Track, tuple[str, ...]]:
    """The fixes of a track's flights with a clock that has no gaps, and notes for people.

    The clock goes on as the track's from the first of them. A track without a flight is returned whole:
    nothing in it tells flying from standing.

    Args:
        track: at least one fix.
        tell_joins: whether a note tells of each flight that begins far from where the last one ended.
    """
    flights = find_flights(track)
    if not flights:
        return track, ("No flight is found in the log; the route follows all of its fixes.",)
    parts = [track.select(slice(flight.first, flight.last + 1)) for flight in flights]
    flown = replace(track.select(_fixes_of(flights)), time_s=_times_without_gaps_s(parts))
    notes = _gap_notes(parts, flights) if tell_joins else []
    if len(flown) < len(track):
        left_out = len(track) - len(flown)
        notes = [f"Left out: {left_out} of {len(track)} fixes, no part of a flight.", *notes]
    return flown, tuple(notes)


def flown_fixes(track: Track) -> Indices:
    """Indices of the fixes of a track that are its flown part."""
    flights = find_flights(track)
    return _fixes_of(flights) if flights else np.arange(len(track))


def _fixes_of(flights: tuple[Flight, ...]) -> Indices:
    """Indices of the fixes of some flights."""
    return np.concatenate([np.arange(flight.first, flight.last + 1) for flight in flights])


def _times_without_gaps_s(parts: list[Track]) -> Floats:
    """Times (n,) by the clock of the first part, with one median step from each part to the next."""
    steps_s = np.concatenate([np.diff(part.time_s) for part in parts])
    median_step_s = float(np.median(steps_s)) if len(steps_s) else 0.0
    times_s = [parts[0].time_s]
    for part in parts[1:]:
        begin_s = float(times_s[-1][-1]) + median_step_s
        times_s.append(part.time_s - part.time_s[0] + begin_s)
    return np.concatenate(times_s)


def _gap_notes(parts: list[Track], flights: tuple[Flight, ...]) -> list[str]:
    """A sentence for each flight that begins far from where the last one ended."""
    notes = []
    for last, part, flight in zip(parts, parts[1:], flights[1:], strict=False):
        gap_m = float(distance_m(last.lat_deg[-1], last.lon_deg[-1], part.lat_deg[0], part.lon_deg[0]))
        if gap_m > MAX_GAP_M:
            notes.append(
                f"Flight {flight.number} begins {gap_m:.0f} m from where flight {flight.number - 1} ended; "
                "a straight leg that was not flown joins them."
            )
    return notes

"""The part of a log that was flown, as one recording: flights joined in order, without the gaps between."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.flights import Flight, find_flights
from flight_replay.logs.track import Track

FAR_JOIN_M = 50.0
"""A way between two flights that is longer than this is worth a word."""


def flown_part(track: Track) -> tuple[Track, tuple[str, ...]]:
    """The flown fixes, their clock running on from flight to flight, and what there is to say about it.

    A log without any flight is taken whole: nothing in it tells flying from standing.
    """
    flights = find_flights(track)
    if not flights:
        return track, ("The log tells of no flight, so all of its fixes are followed.",)
    parts = [track.select(slice(flight.first, flight.last + 1)) for flight in flights]
    index = np.concatenate([np.arange(flight.first, flight.last + 1) for flight in flights])
    joined = replace(track.select(index), time_s=_closed_up_s(parts))
    notes = []
    if len(joined) < len(track):
        left = len(track) - len(joined)
        notes.append(f"{left} of {len(track)} fixes are left out: they were not flown.")
    return joined, (*notes, *_far_joins(parts, flights))


def _closed_up_s(parts: list[Track]) -> Floats:
    """Seconds since the first fix, with one usual step between the last fix of a flight and the next."""
    steps = np.concatenate([np.diff(part.time_s) for part in parts])
    usual_s = float(np.median(steps)) if len(steps) else 0.0
    times, begin_s = [], 0.0
    for part in parts:
        times.append(part.time_s - part.time_s[0] + begin_s)
        begin_s = float(times[-1][-1]) + usual_s
    return np.concatenate(times)


def _far_joins(parts: list[Track], flights: tuple[Flight, ...]) -> list[str]:
    """A sentence for each pair of flights far from each other."""
    notes = []
    for before, after, flight in zip(parts, parts[1:], flights[1:], strict=False):
        ends = before.frame.to_metres(
            [before.lat_deg[-1], after.lat_deg[0]], [before.lon_deg[-1], after.lon_deg[0]]
        )
        apart_m = float(np.linalg.norm(ends[1] - ends[0]))
        if apart_m > FAR_JOIN_M:
            notes.append(
                f"Flight {flight.number} began {apart_m:.0f} m from where flight {flight.number - 1} "
                "ended; the route joins them by a straight way that was not recorded."
            )
    return notes

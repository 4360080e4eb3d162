"""The part of a log that was flown, as one recording: flights joined in order, without the gaps between."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.fit.recording import Recording
from flight_replay.flights import Flight, find_flights
from flight_replay.geodesy import Floats
from flight_replay.home import home_of
from flight_replay.simulator.flat import FlatFrame
from flight_replay.track import Track

FAR_JOIN_M = 50.0
"""A way between two flights that is longer than this is worth a word."""
FLOOR_M = 5.0
"""Recorded heights below this are flown at this height."""
_HOME_SHIFT_M = 20.0


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


def flat_frame(track: Track) -> FlatFrame:
    """ArduPilot's frame around the track's first fix."""
    return FlatFrame(float(track.lat_deg[0]), float(track.lon_deg[0]))


def recording_of(track: Track, altitude_m: float | None) -> Recording:
    """What the fit follows, in ArduPilot's own metres around the track's first fix.

    The vehicle navigates in those: in ground metres, up to 0.5 % different, its time would be too.

    Args:
        track: at least one fix.
        altitude_m: height above home to fly at, or None for the recorded heights.
    """
    times = track.time_s - track.time_s[0]
    heights = believable_heights_m(track) if altitude_m is None else np.full(len(track), float(altitude_m))
    places = flat_frame(track).to_metres(track.lat_deg, track.lon_deg)
    return Recording(times, places, heights, home_of(track).alt_amsl_m)


def believable_heights_m(track: Track) -> Floats:
    """Recorded heights above home (n,), none below the floor.

    Before home is set, the height above it is nonsense (often that above the sea): where the
    implied height of home is far from its median in that boot, the next believable height stands in.
    """
    home_m = track.amsl_m - track.alt_m
    good = np.isfinite(track.alt_m) & np.isfinite(home_m)
    for section in np.unique(track.section):
        here = track.section == section
        if (good & here).any():
            good &= ~here | (np.abs(home_m - np.median(home_m[good & here])) <= _HOME_SHIFT_M)
    if not good.any():
        return np.full(len(track), FLOOR_M)
    index = np.arange(len(track))
    following = index[good][np.minimum(np.searchsorted(index[good], index), good.sum() - 1)]
    return np.asarray(np.maximum(track.alt_m[following], FLOOR_M))

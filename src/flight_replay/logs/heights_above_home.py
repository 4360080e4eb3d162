"""Heights above home, for recordings that have heights above the sea."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.logs.flights import find_flights
from flight_replay.logs.track import Track


def with_heights_above_home(track: Track) -> Track:
    """The track with a height above home wherever it had none, but one above the sea.

    Home is as high as the first fix of each boot that is part of a flight, or else the first one at all.
    """
    unknown = ~np.isfinite(track.alt_m)
    if not unknown.any():
        return track
    flown = np.zeros(len(track), np.bool_)
    for flight in find_flights(track):
        flown[flight.first : flight.last + 1] = True
    alt_m = track.alt_m.copy()
    for boot in np.unique(track.boot):
        here = track.boot == boot
        known = here & np.isfinite(track.amsl_m)
        if known.any():
            first = np.flatnonzero(known & flown if (known & flown).any() else known)[0]
            missing = here & unknown
            alt_m[missing] = track.amsl_m[missing] - track.amsl_m[first]
    return replace(track, alt_m=alt_m)

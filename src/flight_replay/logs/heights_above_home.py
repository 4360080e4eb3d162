"""Heights above home, for recordings that have heights above the sea."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flight_replay.logs.flights import find_flights
from flight_replay.logs.track import Track

_AT_HOME_M = 2.0
"""Barometers drift by less before a flight."""


def with_heights_above_home(track: Track, home_amsl_m: float = math.nan) -> Track:
    """The track with a height above home wherever it had none, but one above the sea.

    Home is as high as the first fix of each boot that is part of a flight, or else the first one at all.
    That of the first boot is at ``home_amsl_m`` where the track does not begin at that height: else it began
    on the ground, perhaps of another place. 0 does not count: some autopilots tell so before home is set.
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
            begin_m = track.amsl_m[np.flatnonzero(known)[0]]
            is_told = boot == track.boot[0] and home_amsl_m != 0 and abs(begin_m - home_amsl_m) > _AT_HOME_M
            ground_m = home_amsl_m if is_told else track.amsl_m[first]
            missing = here & unknown
            alt_m[missing] = track.amsl_m[missing] - ground_m
    return replace(track, alt_m=alt_m)

"""Heights of a recorded track above home, and home itself, where a replay takes off."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.track import Track
from flight_replay.mission.items import Home

Recorded = Literal["recorded"]
RECORDED: Recorded = "recorded"
MIN_ALTITUDE_M = 5.0
"""Recorded heights below this are flown at this height."""
_HOME_SHIFT_M = 20.0


def home_of(track: Track) -> Home:
    """The ground below the first fix of a track that has one; at sea level where its height is not known."""
    ground_m = float(track.amsl_m[0] - track.alt_m[0])
    return Home(
        float(track.lat_deg[0]), float(track.lon_deg[0]), ground_m if math.isfinite(ground_m) else 0.0
    )


def plausible_altitudes_m(track: Track) -> Floats:
    """Recorded heights above home (n,), none below the floor.

    Before home is set, the height above it is nonsense (often that above the sea): where the
    implied height of home is far from its median in that boot, the next believable height stands in.
    """
    home_m = track.amsl_m - track.alt_m
    good = np.isfinite(track.alt_m) & np.isfinite(home_m)
    for boot in np.unique(track.boot):
        here = track.boot == boot
        if (good & here).any():
            good &= ~here | (np.abs(home_m - np.median(home_m[good & here])) <= _HOME_SHIFT_M)
    if not good.any():
        return np.full(len(track), MIN_ALTITUDE_M)
    index = np.arange(len(track))
    following = index[good][np.minimum(np.searchsorted(index[good], index), good.sum() - 1)]
    return np.asarray(np.maximum(track.alt_m[following], MIN_ALTITUDE_M))


def altitudes_m(track: Track, altitude_m: float | Recorded) -> Floats:
    """Height above home to fly at, shape (n,): constant, or as recorded where that can be believed."""
    if altitude_m != RECORDED:
        return np.full(len(track), float(altitude_m))
    return plausible_altitudes_m(track)

"""Where a replay of a recorded track takes off, and returns to."""

from __future__ import annotations

import math

from flight_replay.mission import Home
from flight_replay.track import Track


def home_of(track: Track) -> Home:
    """The ground below the first fix of a track that has one; at sea level where its height is not known."""
    ground_m = float(track.amsl_m[0] - track.alt_m[0])
    return Home(
        float(track.lat_deg[0]), float(track.lon_deg[0]), ground_m if math.isfinite(ground_m) else 0.0
    )

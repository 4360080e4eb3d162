"""Tracks made for tests."""

import numpy as np

from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.logs.track import Track, track_from_columns

FRAME = LocalFrame(64.0, -21.0)


def straight_track(speed_m_s: float = 4.0, fixes: int = 51, altitudes_m: float | list[float] = 0.0) -> Track:
    """A straight flight north, one fix a second."""
    time_s = np.arange(fixes, dtype=float)
    lat, lon = FRAME.to_degrees(np.column_stack([time_s * speed_m_s, np.zeros(fixes)]))
    return track_from_columns(time_s, lat, lon, np.broadcast_to(np.asarray(altitudes_m, float), fixes).copy())

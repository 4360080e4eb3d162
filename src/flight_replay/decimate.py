"""The 3 m rule of DroneKit's example, in true ground metres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flight_replay.geodesy import surface_xyz_m
from flight_replay.track import Track

SPACING_M = 3.0
MAX_POINTS = 100


def spaced(track: Track, spacing_m: float = SPACING_M, max_points: int = MAX_POINTS) -> NDArray[np.intp]:
    """Indices of the first fix, then of every fix more than ``spacing_m`` from the last kept one.

    Stops at ``max_points``; a track that ends before keeps its last fix too, so that the route
    reaches where the recording ended.
    """
    xyz = surface_xyz_m(track.lat_deg, track.lon_deg)
    kept = [0]
    while len(kept) < max_points:
        following = _first_beyond(xyz, kept[-1], spacing_m)
        if following is None:
            break
        kept.append(following)
    last = len(track) - 1
    if len(kept) < max_points and kept[-1] != last:
        kept.append(last)
    return np.array(kept, np.intp)


def _first_beyond(xyz: NDArray[np.float64], start: int, spacing_m: float) -> int | None:
    """Index of the first place after ``start`` farther than ``spacing_m`` from it, in growing looks ahead."""
    begin, size = start + 1, 64
    while begin < len(xyz):
        apart = np.linalg.norm(xyz[begin : begin + size] - xyz[start], axis=1)
        beyond = np.flatnonzero(apart > spacing_m)
        if len(beyond):
            return begin + int(beyond[0])
        begin, size = begin + size, size * 2
    return None

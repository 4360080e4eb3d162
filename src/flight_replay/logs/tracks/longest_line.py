"""Which of a file's lines is the flight, where they have no times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.geometry.geodesy import distance_m
from flight_replay.logs.tracks.track_points import TrackPoints

_JOINED_M = 20.0
"""Mission Planner begins a line at every change of mode, one position behind where the last one ended."""


def longest_line(lines: TrackPoints, our_track: int | None = None) -> tuple[TrackPoints, list[str]]:
    """The line with most points, and a sentence about the others if there are some.

    Lines that begin where the last one ended are joined to one track.

    Args:
        lines: The lines, each a track.
        our_track: The one that this program saved as the recorded track, which counts before all others.
    """
    if our_track is not None:
        return lines.select(lines.track == our_track), []
    begins = np.flatnonzero(np.diff(lines.track, prepend=-1))
    if not len(begins):
        return lines, []
    ends = np.append(begins[1:], len(lines)) - 1
    last, following = ends[:-1], begins[1:]
    lat_deg, lon_deg = lines.lat_deg, lines.lon_deg
    gap_m = distance_m(lat_deg[last], lon_deg[last], lat_deg[following], lon_deg[following])
    chain = np.append(0, np.cumsum(~(gap_m <= _JOINED_M)))
    of_point = np.repeat(chain, ends - begins + 1)
    longest = lines.select(of_point == np.argmax(np.bincount(of_point)))
    joined = replace(longest, track=np.zeros_like(longest.track))
    others = int(chain[-1])
    if not others:
        return joined, []
    left_out = "1 other is" if others == 1 else f"{others} others are"
    return joined, [f"The longest of its lines is read, {left_out} left out"]

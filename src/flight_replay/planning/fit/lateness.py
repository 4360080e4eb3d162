"""How far a flight is from the recording at equal times, and what of that the objective counts.

Near the recorded vehicle that is the way from it. Farther off that tells little: a vehicle that is a lane or
a turn behind may be close by, and would wait there. So what counts there is the way between both along the
recorded line, and less the longer it is, by its logarithm: a vehicle that cannot keep up would else cut its
curves, by tens of metres, to be less late.
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import lengths_along_m, lengths_m
from flight_replay.planning.fit.reference import LocalTrack
from flight_replay.planning.fit.simulated_draft import SimulatedDraft

FAR_M = 6.0
"""Up to so far off it is the way from the recorded vehicle that counts, from twice that on the way along."""
_TANGENT_M = 2.0
"""The recorded line has the direction from so far before to so far after."""
_AROUND_S = 0.1
"""Velocities are those from so long before to so long after."""
_LEAST_STEP = 1e-6


def places_at(time_s: Floats, place_m: Floats, at_s: Floats) -> Floats:
    """Places (m, d) at times (m,) of what is at places (k, d) at rising times (k,)."""
    return np.column_stack([np.interp(at_s, time_s, column) for column in place_m.T])


def velocities_at_m_s(time_s: Floats, place_m: Floats, at_s: Floats) -> Floats:
    """Velocities (m, d) at times (m,) of what is at places (k, d) at rising times (k,)."""
    before_m, later_m = (places_at(time_s, place_m, at_s + shift_s) for shift_s in (-_AROUND_S, _AROUND_S))
    return np.asarray((later_m - before_m) / (2 * _AROUND_S))


def position_offsets_m(flown: SimulatedDraft, recording: LocalTrack) -> Floats:
    """Vectors (n, axes) from every fix to where the vehicle is at that time; in the end it stays there."""
    return places_at(flown.time_s, flown.place_m[:, : recording.axes], recording.time_s) - recording.places_m


def counted_offsets_m(off_m: Floats, recording: LocalTrack, flown_s: Floats) -> Floats:
    """What counts of vectors from fixes to the vehicle at their times (n, axes), as vectors.

    Args:
        off_m: as from ``position_offsets_m``.
        recording: at least one fix.
        flown_s: when the vehicle flies by each fix (n,).
    """
    far = np.clip(lengths_m(off_m) / FAR_M - 1.0, 0.0, 1.0)
    if not far.any():
        return off_m
    line_m = recording.places_m
    rising = _LEAST_STEP * np.arange(len(line_m))
    along_m = lengths_along_m(line_m) + rising
    there_m = np.interp(recording.time_s, np.maximum.accumulate(flown_s) + rising, along_m)
    ahead_m, behind_m = (places_at(along_m, line_m, there_m + shift) for shift in (_TANGENT_M, -_TANGENT_M))
    tangent_m = ahead_m - behind_m
    tangent = tangent_m / np.maximum(lengths_m(tangent_m), _LEAST_STEP)[:, None]
    return off_m + far[:, None] * (tangent * (there_m - along_m)[:, None] - off_m)


def lateness_cost_m(late_m: Floats) -> Floats:
    """What being so far off counts (n,): as far as it is, beyond ``FAR_M`` by its logarithm."""
    return np.asarray(np.minimum(late_m, FAR_M) + FAR_M * np.log(np.maximum(late_m / FAR_M, 1.0)))


def lateness_slope(late_m: Floats) -> Floats:
    """What a metre more counts (n,)."""
    return np.asarray(FAR_M / np.maximum(late_m, FAR_M))

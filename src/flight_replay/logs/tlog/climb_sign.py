"""Which way is up in GLOBAL_POSITION_INT.vz: MAVLink sends it downward, ArduCopter 3.3 and others upward."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.logs.track import Track

_LONGEST_STEP_S = 2.0
_LEAST_CLIMB_M = 5.0
"""Sums of less tell nothing: heights and velocities are noisy."""
_CLEARLY = 0.5


def with_climbs_as_heights(track: Track) -> Track:
    """The track, its vertical velocity turned round where its heights clearly say so."""
    step_s, climb_m = np.diff(track.time_s), np.diff(track.alt_m)
    told_m = (track.up_m_s[1:] + track.up_m_s[:-1]) / 2 * step_s
    near = (step_s < _LONGEST_STEP_S) & (track.boot[1:] == track.boot[:-1])
    climb_m, told_m = climb_m[near], told_m[near]
    off_m, turned_off_m = np.abs(climb_m - told_m).sum(), np.abs(climb_m + told_m).sum()
    if np.abs(climb_m).sum() < _LEAST_CLIMB_M or turned_off_m > _CLEARLY * off_m:
        return track
    return replace(track, up_m_s=-track.up_m_s)

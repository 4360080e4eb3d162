"""Altitudes above home of a recorded track, and home itself, where a replay takes off."""

from __future__ import annotations

from typing import Literal

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.logs.track import Armed, Track
from flight_replay.mission.items import Home

Recorded = Literal["recorded"]
RECORDED: Recorded = "recorded"
FLOOR_M = 5.0
"""The default of ``--floor``: recorded altitudes below it are flown at it, as barometers drift by metres."""
_MAX_HOME_ERROR_M = 20.0
"""Home's altitude above the sea is constant once home is set, but for the drift of barometer and GPS."""
_HOME_STEP_M = 1.0
"""So far altitudes above home step, and those above the sea less than half of it, where home is moved."""
_SAME_FLIGHT_S = 5.0
"""Between two flights, when home is set anew, more time than this is left out."""


def home_of(track: Track) -> Home:
    """The ground below the first fix of a track that has one, as high as the first that tells it has it.

    Before home is set ArduCopter tells 0 for its height: that counts only where nothing else is told.
    """
    grounds_m = track.amsl_m - track.alt_m
    known_m = grounds_m[np.isfinite(grounds_m)]
    ground_m = float(known_m[np.argmax(known_m != 0.0)]) if len(known_m) else None
    return Home(float(track.lat_deg[0]), float(track.lon_deg[0]), ground_m)


def altitudes_m(
    track: Track, altitude_m: float | Recorded, floor_m: float = FLOOR_M, raise_m: float = 0.0
) -> Floats:
    """Altitude above home to fly at (n,): constant, or as recorded where that is plausible, above a floor.

    Args:
        track: fixes of one vehicle.
        altitude_m: constant, or as recorded.
        floor_m: the lowest that is flown of recorded ones.
        raise_m: so much higher than recorded.

    Raises:
        MissionError: they are to be as recorded, and no height was.
    """
    if altitude_m != RECORDED:
        return np.full(len(track), float(altitude_m))
    return plausible_altitudes_m(track, floor_m, raise_m)


def plausible_altitudes_m(track: Track, floor_m: float = FLOOR_M, raise_m: float = 0.0) -> Floats:
    """Recorded altitudes above home (n,), higher by ``raise_m``, none below ``floor_m``.

    Before home is set, the altitude above it is meaningless (often that above the sea): where the
    implied altitude of home is far from its median in that boot, the next plausible one is taken. In a
    boot without altitudes above the sea all are plausible. Where home is moved in flight, altitudes
    stay above the one before.

    Raises:
        MissionError: there is no plausible altitude.
    """
    alt_m = track.alt_m + _home_raised_m(track)
    home_amsl_m = track.amsl_m - alt_m
    plausible = np.isfinite(alt_m)
    for boot in np.unique(track.boot):
        known = np.isfinite(home_amsl_m) & (track.boot == boot)
        if known.any():
            error_m = np.abs(home_amsl_m - np.median(home_amsl_m[known]))
            plausible &= (track.boot != boot) | (error_m <= _MAX_HOME_ERROR_M)
    if not plausible.any():
        raise MissionError("the recording has no heights; choose one in metres, such as --altitude 30")
    index = np.flatnonzero(plausible)
    following = index[np.minimum(np.searchsorted(index, np.arange(len(track))), len(index) - 1)]
    return np.asarray(np.maximum(alt_m[following] + raise_m, floor_m))


def _home_raised_m(track: Track) -> Floats:
    """How much higher home is at each fix (n,) than at the begin of that flight; 0 where nothing tells.

    DO_SET_HOME moves it. The vehicle goes on flying, and only its altitude above home steps.
    """
    home_amsl_m = track.amsl_m - track.alt_m
    flying = (track.armed == Armed.YES) & (home_amsl_m != 0.0)  # Before home is set its altitude is 0.
    same_flight = flying[1:] & flying[:-1] & (np.diff(track.time_s) <= _SAME_FLIGHT_S)
    same_flight &= np.diff(track.boot) == 0
    step_m, climb_m = np.diff(track.alt_m), np.diff(track.amsl_m)
    moved = same_flight & (np.abs(step_m) > _HOME_STEP_M) & (np.abs(climb_m) < np.abs(step_m) / 2)
    raised_m = np.concatenate([[0.0], np.cumsum(np.where(moved, climb_m - step_m, 0.0))])
    first = np.concatenate([[0], np.where(same_flight, 0, np.arange(1, len(track)))])
    return np.asarray(raised_m - raised_m[np.maximum.accumulate(first)])

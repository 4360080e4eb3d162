"""What makes a recording look like no multicopter's flight; said before it is planned, or refused."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.error_statistics import error_statistics
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.logs.flights import Flight
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import Track
from flight_replay.mission.items import Mission
from flight_replay.planning.altitude import plausible_altitudes_m

_STILL_M = 1.0
"""Waypoints closer together than this ask for no motion; positions of a receiver at rest wander by more."""
_PARKED_M = 10.0
_CLIMBS_M = 5.0
"""Heights differ by more than this where the vehicle climbed; barometers drift by less."""
_CRUISE_M_S = 15.0
"""Above the cruising speed of multicopters, though not of the fastest; aeroplanes cruise faster."""


def doubts(recording: Recording, flights: Sequence[Flight], track: Track) -> list[str]:
    """Sentences about a recording, and the part of its track that is replayed, that may be no flight."""
    said = []
    if recording.is_multicopter is False:
        said.append(
            f"This is the log of a {recording.vehicle_type}, not of a multicopter, which may not fly it alike"
        )
    extent_m = float(np.ptp(track.north_east_m(), axis=0).max())
    if not flights and extent_m < _PARKED_M:
        said.append(f"No fix is armed or moves: the vehicle seems parked, within {extent_m:.0f} m")
    elif not flights:
        said.append(f"The log tells of no armed flight, though its positions span {extent_m:.0f} m")
    elif extent_m < _PARKED_M:
        said.append(f"The recording stays within {extent_m:.1f} m of one place")
    speed = error_statistics(_cruise_m_s(track))
    if speed is not None and speed.mean > _CRUISE_M_S:
        said.append(f"The recording moves at {speed.mean:.0f} m/s on average, faster than multicopters do")
    return said


def _cruise_m_s(track: Track) -> Floats:
    """Known ground speeds (n,) while the vehicle moved."""
    speed_m_s = np.hypot(track.north_m_s, track.east_m_s)
    return speed_m_s[speed_m_s > 1.0]  # not those that are no number


def check_moves(mission: Mission, track: Track, chosen_by: str) -> None:
    """Refuse a mission of several waypoints that are all at one place.

    Args:
        mission: holds them.
        track: what they are of.
        chosen_by: the options that decide which of its fixes are waypoints.

    Raises:
        MissionError: They are.
    """
    waypoints = [item for _, item in mission.waypoints]
    first = waypoints[0]
    frame = LocalFrame(first.lat_deg, first.lon_deg)
    ground_m = frame.to_metres(
        np.array([item.lat_deg for item in waypoints]), np.array([item.lon_deg for item in waypoints])
    )
    up_m = np.array([item.alt_m - first.alt_m for item in waypoints])
    if len(waypoints) <= 1 or np.hypot(np.hypot(*ground_m.T), up_m).max() >= _STILL_M:
        return
    close = f"its {len(waypoints)} waypoints are within {_STILL_M:g} m of each other"
    extent_m = float(np.ptp(track.north_east_m(), axis=0).max())
    if extent_m >= _PARKED_M:
        raise MissionError(f"the recording moves within {extent_m:.0f} m, but {close}; change {chosen_by}")
    climb_m = _climb_m(track)
    if climb_m > _CLIMBS_M:
        raise MissionError(
            f"the recording moves up and down, by {climb_m:.0f} m, but {close}; fly its heights, with "
            "--altitude recorded and a --floor below them"
        )
    followed = ", or follow where it hovers and points with --mode guided" if track.timed else ""
    raise MissionError(
        f"the recording does not move: {close}; choose another log, another flight of it with --flight"
        f"{followed}"
    )


def _climb_m(track: Track) -> float:
    """How far the highest fix of a track is above the lowest; 0 where no height is known."""
    if not np.isfinite(track.alt_m).any():
        return 0.0
    return float(np.ptp(plausible_altitudes_m(track, floor_m=-np.inf)))

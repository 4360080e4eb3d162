"""The 3 m rule of DroneKit's example, in true ground metres."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.geodesy import surface_xyz_m
from flight_replay.geometry.polyline import segment_lengths_m
from flight_replay.logs.track import Track
from flight_replay.mission.items import Mission, MissionItem, change_speed, speed_from_the_start, waypoint
from flight_replay.planning.altitude import FLOOR_M, RECORDED, Recorded, home_of
from flight_replay.planning.heights import heights_of
from flight_replay.planning.route import Route, route_of
from flight_replay.simulator.dynamics.limits import Limits

SPACING_M = 3.0
MAX_POINTS = 100
SPEED_RATIO = 1.25
"""A recorded leg faster or slower than the speed in force by this ratio is worth a speed change."""
MIN_SPEED_M_S = 0.5
"""Slowest speed worth asking for: ArduCopter ignores less than 0.2 m/s, 3.3 less than 1 m/s."""
MAX_SPEED_M_S = 30.0
"""Where the clock stands still, no leg is faster than this."""


def decimate(
    track: Track, spacing_m: float = SPACING_M, max_points: int = MAX_POINTS, up_m: Floats | None = None
) -> Indices:
    """Indices of the first fix, then of every fix more than ``spacing_m`` from the last kept one.

    Stops at ``max_points``; a track that ends before keeps its last fix too, so that the route
    reaches where the recording ended.

    Args:
        track: at least one fix.
        spacing_m: over the ground, or in space where heights are given.
        max_points: at least one.
        up_m: the heights (n,) at which the fixes are to be flown, where they are not all the same.
    """
    xyz = surface_xyz_m(track.lat_deg, track.lon_deg)
    if up_m is not None:
        xyz = np.column_stack([xyz, up_m])
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


def _first_beyond(xyz: Floats, start: int, spacing_m: float) -> int | None:
    """Index of the first position behind ``start`` that is farther than ``spacing_m`` from it, or None."""
    # In growing blocks: mostly the next few are enough, and a hover may be long.
    begin, size = start + 1, 64
    while begin < len(xyz):
        apart = np.linalg.norm(xyz[begin : begin + size] - xyz[start], axis=1)
        beyond = np.flatnonzero(apart > spacing_m)
        if len(beyond):
            return begin + int(beyond[0])
        begin, size = begin + size, size * 2
    return None


def spaced_route(  # noqa: PLR0913
    track: Track,
    *,
    spacing_m: float = SPACING_M,
    max_points: int = MAX_POINTS,
    altitude_m: float | Recorded = 30.0,
    floor_m: float = FLOOR_M,
    raise_m: float = 0.0,
    speed_m_s: float | Recorded | None = None,
    limits: Limits | None = None,
) -> Route:
    """The route of DroneKit's example: straight waypoints at kept fixes, see ``decimate``.

    Args:
        track: at least one fix.
        spacing_m: waypoints are farther apart than this, over the ground, or with recorded heights in space.
        max_points: maximum number of waypoints; speed changes come on top.
        altitude_m: above home, constant or as recorded: no top is cut off to be in time, as legs are late.
        floor_m: lower recorded altitudes are raised to this.
        raise_m: so much higher than recorded.
        speed_m_s: ground speed, as recorded, or None for the vehicle's own setting.
        limits: what the vehicle may do; ArduCopter's defaults if None.
    """
    limits = limits or Limits()
    heights = heights_of(track, altitude_m, floor_m, raise_m=raise_m)
    kept = decimate(track, spacing_m, max_points, heights.planned_m if altitude_m == RECORDED else None)
    fixes = track.select(kept)
    waypoints = [
        waypoint(float(lat), float(lon), float(altitude))
        for lat, lon, altitude in zip(fixes.lat_deg, fixes.lon_deg, heights.planned_m[kept], strict=True)
    ]
    covered = slice(0, int(kept[-1]) + 1)
    return route_of(
        "spacing",
        Mission(tuple(_with_speeds(waypoints, fixes, speed_m_s)), home_of(track)),
        track.select(covered),
        heights=heights.select(covered),
        recording=track,
        limits=limits,
    )


def _with_speeds(
    waypoints: list[MissionItem], fixes: Track, speed_m_s: float | Recorded | None
) -> list[MissionItem]:
    """The waypoints at kept fixes, each behind the speed change for the leg to it if it needs one."""
    if speed_m_s is None:
        return waypoints
    if speed_m_s != RECORDED:
        return [*speed_from_the_start(float(speed_m_s)), *waypoints]
    items, in_force = waypoints[:1], np.inf
    for item, speed in zip(waypoints[1:], _leg_speeds_m_s(fixes), strict=True):
        if max(speed / in_force, in_force / speed) > SPEED_RATIO:
            items.append(change_speed(round(speed, 2)))
            in_force = speed
        items.append(item)
    return items


def _leg_speeds_m_s(fixes: Track) -> list[float]:
    """Mean recorded ground speed of every leg between kept fixes, metres per second."""
    lengths_m = segment_lengths_m(fixes.north_east_m())
    durations_s = np.diff(fixes.time_s)
    speeds = np.divide(lengths_m, durations_s, out=np.full(len(lengths_m), np.inf), where=durations_s > 0)
    return [float(speed) for speed in np.clip(speeds, MIN_SPEED_M_S, MAX_SPEED_M_S)]

"""From a recorded track to the route that will be flown, and how well that follows the recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from flight_replay.compare import Spread, spread
from flight_replay.decimate import MAX_POINTS, SPACING_M, spaced
from flight_replay.geodesy import Floats
from flight_replay.home import home_of
from flight_replay.matching import in_order
from flight_replay.mission import Command, Mission, MissionItem, change_speed, waypoint
from flight_replay.option_types import RECORDED, Recorded
from flight_replay.path import Path, planned_path
from flight_replay.simulator.limits import Limits
from flight_replay.simulator.timetable import straight_duration_s
from flight_replay.track import Track

SPEED_RATIO = 1.25
"""A recorded leg faster or slower than the speed in force by this ratio is worth a speed change."""
MIN_SPEED_M_S = 0.5
"""Slowest speed worth asking for: ArduCopter ignores less than 0.2 m/s, 3.3 less than 1 m/s."""
_STEP_S = 0.1
"""Steps of the flight model that are good enough for a duration: 0.2 % off on 3 m legs."""
_SHORT_LEG_M = 6.0
"""Straight legs up to this are flown so slowly that the vehicle is where its target is: 0.5 % off."""
_PIECE_M = 0.5
"""Pieces of path that are good enough for a planned distance: 1 mm off on average, at a third of the time."""
_LONGEST_SIMULATED_M = 50_000.0
"""Farther than copters fly; such a route is mostly flown at full speed."""


@dataclass(frozen=True, slots=True)
class Predicted:
    """How the model of ArduCopter flies a route: distances from the recording in space and in time."""

    in_space: Spread
    in_time: Spread


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """A mission, the recorded fixes that it covers, its distance from them as planned, and its duration.

    ``predicted_duration_s`` is the time in AUTO that the vehicle is expected to need, ``predicted``
    the expected distances where the planning found them, ``notes`` are sentences for a person.
    ``raised`` holds the fields of ``Limits`` that the vehicle must have raised to fly it, SI units.
    """

    method: str
    mission: Mission
    covered: Track
    path: Path
    planned_error: Spread
    predicted_duration_s: float
    predicted: Predicted | None = None
    raised: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def route_through(method: str, mission: Mission, covered: Track) -> Route:
    """The route of a mission that was made from ``covered``, with its planned error.

    Args:
        method: name of the way in which the mission was made.
        mission: at least one place.
        covered: at least one fix.
    """
    path = planned_path(mission, covered.frame)
    matching = in_order(covered.north_east_m(), path.north_east_m, _PIECE_M)
    error = spread(matching.distance_m)
    assert error is not None, "a covered track has fixes"
    return Route(method, mission, covered, path, error, _duration_s(mission, path))


def spaced_route(
    track: Track,
    *,
    spacing_m: float = SPACING_M,
    max_points: int = MAX_POINTS,
    altitude_m: float | Recorded = 30.0,
    speed_m_s: float | Recorded | None = None,
) -> Route:
    """The route of DroneKit's example: straight waypoints at kept fixes, see ``decimate.spaced``.

    Args:
        track: at least one fix.
        spacing_m: least distance between waypoints.
        max_points: most waypoints; speed changes come on top.
        altitude_m: height above home, constant or as recorded.
        speed_m_s: ground speed, as recorded, or None for the vehicle's own setting.
    """
    kept = spaced(track, spacing_m, max_points)
    places = track.select(kept)
    heights = heights_m(track, altitude_m)[kept]
    waypoints = [
        waypoint(float(lat), float(lon), float(height))
        for lat, lon, height in zip(places.lat_deg, places.lon_deg, heights, strict=True)
    ]
    mission = Mission(tuple(_with_speeds(waypoints, places, speed_m_s)), home_of(track))
    covered = track.select(slice(0, int(kept[-1]) + 1))
    return route_through("spacing", mission, covered)


def heights_m(track: Track, altitude_m: float | Recorded) -> Floats:
    """Height above home to fly at, shape (n,): constant, or as recorded where that can be believed."""
    if altitude_m != RECORDED:
        return np.full(len(track), float(altitude_m))
    from flight_replay.fit.flown import believable_heights_m

    return believable_heights_m(track)


def _duration_s(mission: Mission, path: Path) -> float:
    """How long a vehicle at its defaults would take for the mission, from above home, seconds."""
    limits = Limits()
    if path.length_m > _LONGEST_SIMULATED_M:
        return path.length_m / limits.wp_speed_m_s
    if all(item.command == Command.WAYPOINT for item in mission.items) and _longest_m(path) <= _SHORT_LEG_M:
        places = np.column_stack([path.north_east_m, path.up_m]).tolist()
        return straight_duration_s([(north, east, up) for north, east, up in places], limits)
    # The model of the whole vehicle takes as long to import and run as all else in a dry run.
    from flight_replay.simulator.model import simulate

    begin_s, end_s = simulate(mission, limits, step_s=_STEP_S).auto_s
    return end_s - begin_s


def _longest_m(path: Path) -> float:
    """Longest straight piece of the path."""
    return float(np.linalg.norm(np.diff(path.north_east_m, axis=0), axis=1).max(initial=0.0))


def _with_speeds(
    waypoints: list[MissionItem], places: Track, speed_m_s: float | Recorded | None
) -> list[MissionItem]:
    """The waypoints with the speed changes that hold for the leg to the waypoint behind them."""
    if speed_m_s is None:
        return waypoints
    if speed_m_s != RECORDED:
        return [change_speed(float(speed_m_s)), *waypoints]
    items, in_force = waypoints[:1], np.inf
    for item, speed in zip(waypoints[1:], _leg_speeds_m_s(places), strict=True):
        if max(speed / in_force, in_force / speed) > SPEED_RATIO:
            items.append(change_speed(round(speed, 2)))
            in_force = speed
        items.append(item)
    return items


def _leg_speeds_m_s(places: Track) -> list[float]:
    """Mean recorded ground speed of every leg between kept fixes, metres per second."""
    steps_m = np.linalg.norm(np.diff(places.north_east_m(), axis=0), axis=1)
    steps_s = np.diff(places.time_s)
    speeds = np.divide(steps_m, steps_s, out=np.full(len(steps_m), np.inf), where=steps_s > 0)
    return [float(speed) for speed in np.clip(speeds, MIN_SPEED_M_S, 30.0)]

"""What pictures of a replay show, in local metres and in seconds since each clock's start.

The frame is that of the route's first recorded fix. Recorded time counts from that fix, flown time
from the reaching of the first waypoint, as the distance in time does (DESIGN.md, "The measures").
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.distances import ErrorStatistics, path_errors_m
from flight_replay.logs.track import Track
from flight_replay.mission.path import destinations, path_through
from flight_replay.output.outcome import Outcome
from flight_replay.planning.route import Route
from flight_replay.supervisor.flight_plan import FlightRecord

RECORDED, PLANNED, FLOWN = "#8c8c8c", "#0072B2", "#D55E00"
"""Line colours in every picture: Okabe and Ito's, which the colour-blind tell apart."""
DRAWN_WITHIN_M = 0.05
"""How far the lines that stand for a spline leg may lie from it: nobody sees that in a picture."""
MOST_POINTS = 4000
"""No picture shows more points of a line than this."""


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """One vehicle's way, n points: ground places (n, 2) north and east, seconds, height, ground speed."""

    north_east_m: Floats
    time_s: Floats
    alt_m: Floats
    speed_m_s: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Distances:
    """Distances (n,) in metres over recorded time (n,) in seconds, and the summary of all of them."""

    time_s: Floats
    distance_m: Floats
    spread: ErrorStatistics


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """All that a picture of a replay draws; what there is nothing of is None."""

    recorded: Flown
    planned_m: Floats
    waypoints_m: Floats
    waypoint_seqs: tuple[int, ...]
    planned_distance: Distances
    flown: Flown | None
    in_space: Distances | None
    in_time: Distances | None
    reached: tuple[tuple[float, float], ...]
    """(time, planned height) of each waypoint reached."""


def curves(route: Route, record: FlightRecord | None = None, outcome: Outcome | None = None) -> Curves:
    """The curves of a route, and of the flight that followed it if there was one."""
    covered, frame = route.covered, route.covered.frame
    recorded_s = covered.time_s - covered.time_s[0]
    fixes_m = covered.north_east_m(frame)
    places = route.mission.waypoints
    planned_line = path_through(destinations(route.mission.items, frame), tolerance_m=DRAWN_WITHIN_M)
    return Curves(
        recorded=_way(covered, fixes_m, recorded_s),
        planned_m=planned_line.north_east_m,
        waypoints_m=frame.to_metres(
            [item.lat_deg for _, item in places], [item.lon_deg for _, item in places]
        ),
        waypoint_seqs=tuple(seq for seq, _ in places),
        planned_distance=_over_time(
            recorded_s, path_errors_m(fixes_m, route.path.north_east_m), route.planned_error
        ),
        flown=_flown(route, record) if record is not None and len(record.flown) else None,
        in_space=_over_time(recorded_s, outcome.space_m, outcome.in_space)
        if outcome and outcome.in_space
        else None,
        in_time=_over_time(recorded_s, outcome.time_m, outcome.in_time)
        if outcome and outcome.in_time
        else None,
        reached=_reached(route, record) if record is not None else (),
    )


def start_s(route: Route, record: FlightRecord) -> float:
    """The vehicle's time when it reached the first waypoint; if it did not, when AUTO began."""
    return dict(record.reached).get(route.mission.waypoints[0][0], record.auto_start_s)


def _flown(route: Route, record: FlightRecord) -> Flown:
    frame = route.covered.frame
    return _way(record.flown, record.flown.north_east_m(frame), record.flown.time_s - start_s(route, record))


def _reached(route: Route, record: FlightRecord) -> tuple[tuple[float, float], ...]:
    heights = {seq: item.alt_m for seq, item in route.mission.waypoints}
    start = start_s(route, record)
    return tuple((time_s - start, heights[seq]) for seq, time_s in record.reached if seq in heights)


def _way(track: Track, north_east_m: Floats, time_s: Floats) -> Flown:
    keep = thinned(len(track))
    speed_m_s = ground_speed_m_s(track, north_east_m)
    return Flown(north_east_m[keep], time_s[keep], track.alt_m[keep], speed_m_s[keep])


def _over_time(time_s: Floats, distances_m: Floats, summary: ErrorStatistics) -> Distances:
    keep = peaks(distances_m)
    return Distances(time_s[keep], distances_m[keep], summary)


def ground_speed_m_s(track: Track, north_east_m: Floats) -> Floats:
    """The vehicle's own ground speed, or where it told none, that of its places; 0 for a single fix."""
    told = np.hypot(track.north_m_s, track.east_m_s)
    if np.isfinite(told).all() or len(track) < 2:
        return np.nan_to_num(told)
    lasted_s = np.diff(track.time_s)
    moved_m = np.linalg.norm(np.diff(north_east_m, axis=0), axis=1)
    between = np.divide(moved_m, lasted_s, out=np.zeros_like(moved_m), where=lasted_s > 0)
    return np.where(np.isfinite(told), told, np.append(between[:1], between))


def thinned(n: int, most: int = MOST_POINTS) -> NDArray[np.intp]:
    """At most ``most`` of ``n`` indices, evenly spread, both ends kept."""
    return np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(np.intp))


def peaks(values: Floats, most: int = MOST_POINTS) -> NDArray[np.intp]:
    """At most ``most`` indices, such that the highest value of every stretch is among them."""
    if len(values) <= most:
        return np.arange(len(values))
    edges = np.linspace(0, len(values), most + 1).astype(np.intp)
    return np.array([a + int(np.argmax(values[a:b])) for a, b in pairwise(edges)])

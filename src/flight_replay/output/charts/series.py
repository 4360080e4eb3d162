"""The series that charts of a replay draw, in local metres and in seconds.

The frame is that of the route's first recorded fix. Recorded time counts from that fix, flown time
from when the vehicle reached the first waypoint, as the position error does.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.distances import ErrorStatistics, path_errors_m
from flight_replay.logs.track import Track
from flight_replay.mission.path import destinations, path_through
from flight_replay.output.outcome import Outcome
from flight_replay.planning.route import Route
from flight_replay.supervisor.flight_plan import FlightRecord

RECORDED_COLOUR, PLANNED_COLOUR, FLOWN_COLOUR = "#8c8c8c", "#0072B2", "#D55E00"
"""Line colours of every chart, from the colour-blind safe palette of Okabe and Ito."""
CURVE_TOLERANCE_M = 0.05
"""Largest distance between a spline leg and the line segments that are drawn for it."""
MAX_CHART_POINTS = 4000
"""Most points of a line in a chart."""


@dataclass(frozen=True, slots=True, eq=False)
class TrackSeries:
    """One vehicle's track, n points: (north, east) as (n, 2), time, altitude above home, ground speed."""

    north_east_m: Floats
    time_s: Floats
    alt_m: Floats
    speed_m_s: Floats


@dataclass(frozen=True, slots=True, eq=False)
class ErrorSeries:
    """Errors (n,) over recorded time (n,), and their statistics before thinning."""

    time_s: Floats
    error_m: Floats
    statistics: ErrorStatistics


@dataclass(frozen=True, slots=True, eq=False)
class ReplaySeries:
    """Everything that the charts of a replay draw; what does not exist is None.

    ``reached`` holds (time, planned altitude) of each waypoint reached.
    """

    recorded: TrackSeries
    planned_m: Floats
    waypoints_m: Floats
    waypoint_seqs: tuple[int, ...]
    planned_error: ErrorSeries
    flown: TrackSeries | None
    path_error: ErrorSeries | None
    position_error: ErrorSeries | None
    reached: tuple[tuple[float, float], ...]


def replay_series(
    route: Route, record: FlightRecord | None = None, outcome: Outcome | None = None
) -> ReplaySeries:
    """The series of a route, and of the flight that followed it if there was one."""
    covered, frame = route.covered, route.covered.frame
    recorded_s = covered.time_s - covered.time_s[0]
    fixes_m = covered.north_east_m(frame)
    waypoints = route.mission.waypoints
    planned = path_through(destinations(route.mission.items, frame), tolerance_m=CURVE_TOLERANCE_M)
    planned_errors_m = path_errors_m(fixes_m, route.path.north_east_m)
    return ReplaySeries(
        recorded=_track_series(covered, fixes_m, recorded_s),
        planned_m=planned.north_east_m,
        waypoints_m=frame.to_metres(
            [item.lat_deg for _, item in waypoints], [item.lon_deg for _, item in waypoints]
        ),
        waypoint_seqs=tuple(seq for seq, _ in waypoints),
        planned_error=_error_series(recorded_s, planned_errors_m, route.planned_error),
        flown=_flown_series(route, record) if record is not None and len(record.flown) else None,
        path_error=_error_series(recorded_s, outcome.path_errors_m, outcome.path_error)
        if outcome and outcome.path_error
        else None,
        position_error=_error_series(recorded_s, outcome.position_errors_m, outcome.position_error)
        if outcome and outcome.position_error
        else None,
        reached=_reached(route, record) if record is not None else (),
    )


def flown_start_s(route: Route, record: FlightRecord) -> float:
    """The vehicle's time when it reached the first waypoint, or when AUTO began if it never did."""
    return dict(record.reached).get(route.mission.waypoints[0][0], record.auto_start_s)


def _flown_series(route: Route, record: FlightRecord) -> TrackSeries:
    north_east_m = record.flown.north_east_m(route.covered.frame)
    return _track_series(record.flown, north_east_m, record.flown.time_s - flown_start_s(route, record))


def _reached(route: Route, record: FlightRecord) -> tuple[tuple[float, float], ...]:
    altitudes_m = {seq: item.alt_m for seq, item in route.mission.waypoints}
    start_s = flown_start_s(route, record)
    return tuple((time_s - start_s, altitudes_m[seq]) for seq, time_s in record.reached if seq in altitudes_m)


def _track_series(track: Track, north_east_m: Floats, time_s: Floats) -> TrackSeries:
    keep = thin_indices(len(track))
    speed_m_s = ground_speed_m_s(track, north_east_m)
    return TrackSeries(north_east_m[keep], time_s[keep], track.alt_m[keep], speed_m_s[keep])


def _error_series(time_s: Floats, errors_m: Floats, statistics: ErrorStatistics) -> ErrorSeries:
    keep = peak_indices(errors_m)
    return ErrorSeries(time_s[keep], errors_m[keep], statistics)


def ground_speed_m_s(track: Track, north_east_m: Floats) -> Floats:
    """Recorded ground speed (n,); where it is missing, that between two positions, 0 for a single fix."""
    recorded_m_s = np.hypot(track.north_m_s, track.east_m_s)
    if np.isfinite(recorded_m_s).all() or len(track) < 2:
        return np.nan_to_num(recorded_m_s)
    step_s = np.diff(track.time_s)
    step_m = np.linalg.norm(np.diff(north_east_m, axis=0), axis=1)
    step_m_s = np.divide(step_m, step_s, out=np.zeros_like(step_m), where=step_s > 0)
    return np.where(np.isfinite(recorded_m_s), recorded_m_s, np.append(step_m_s[:1], step_m_s))


def thin_indices(n: int, most: int = MAX_CHART_POINTS) -> Indices:
    """At most ``most`` of ``n`` indices, evenly spaced, first and last included."""
    return np.unique(np.linspace(0, n - 1, min(n, most)).round().astype(np.intp))


def peak_indices(values: Floats, most: int = MAX_CHART_POINTS) -> Indices:
    """At most ``most`` indices: that of the highest value in each of ``most`` equal parts."""
    if len(values) <= most:
        return np.arange(len(values))
    edges = np.linspace(0, len(values), most + 1).astype(np.intp)
    return np.array([a + int(np.argmax(values[a:b])) for a, b in pairwise(edges)])

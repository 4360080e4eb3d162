"""The series that charts of a replay draw, in local metres and in seconds.

The frame is that of the route's first fix. Times are those of the errors at equal times: recorded time
counts from the first fix that was flown, flown time from when the vehicle reached the first waypoint; where
a recording is followed, both are by the reference's clock.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.error_statistics import ErrorStatistics
from flight_replay.geometry.flight_errors import Errors, FlightErrors, PathErrors
from flight_replay.logs.track import UNTIMED_SPEED_M_S, Track
from flight_replay.mission.path import destinations, path_through
from flight_replay.output.outcome import Outcome, flown_start_s, followed_part
from flight_replay.planning.route import Route
from flight_replay.supervisor.flight_plan import FlightRecord

RECORDED_COLOUR, PLANNED_COLOUR, FLOWN_COLOUR = "#8c8c8c", "#0072B2", "#D55E00"
PREDICTED_COLOUR = "#009E73"
"""Line colours of every chart, from the colour-blind safe palette of Okabe and Ito."""
NOT_COVERED_COLOUR = "#d4d4d4"
"""The colour of what was recorded, but is not covered."""
NOT_COVERED = "recorded, not covered"
LINE_COLOURS = {
    NOT_COVERED: NOT_COVERED_COLOUR,
    "recorded": RECORDED_COLOUR,
    "planned": PLANNED_COLOUR,
    "predicted": PREDICTED_COLOUR,
    "flown": FLOWN_COLOUR,
}
CURVE_TOLERANCE_M = 0.05
"""Largest distance between a spline leg and the line segments that are drawn for it."""
_UNTIMED_LABEL = f"way along the recording (s at {UNTIMED_SPEED_M_S:g} m/s)"
MAX_CHART_POINTS = 4000
"""Most points of a line in a chart."""
SMALLEST_RANGE = 0.1
"""Of an axis of errors, heights or speeds: millimetres must not look like much."""
SMALLEST_MAP_M = 5.0
"""So much is on a map at least: of a hover, neither noise nor rounding must look like a way."""


@dataclass(frozen=True, slots=True, eq=False)
class TrackSeries:
    """One vehicle's track, n points: (north, east) as (n, 2), time, altitude above home, ground speed."""

    north_east_m: Floats
    time_s: Floats
    alt_m: Floats
    speed_m_s: Floats


@dataclass(frozen=True, slots=True, eq=False)
class ErrorSeries:
    """Errors (n,) over time (n,), and their statistics before thinning."""

    time_s: Floats
    error: Floats
    statistics: ErrorStatistics


@dataclass(frozen=True, slots=True, eq=False)
class PathErrorSeries:
    """The path error both ways; None where there is nothing to compare."""

    recorded_to_path: ErrorSeries | None
    path_to_recorded: ErrorSeries | None


@dataclass(frozen=True, slots=True, eq=False)
class FlightErrorSeries:
    """All errors of a flight; None where there is nothing to compare."""

    path: PathErrorSeries | None = None
    position: ErrorSeries | None = None
    height: ErrorSeries | None = None
    heading: ErrorSeries | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ReplaySeries:
    """Everything that the charts of a replay draw; what does not exist is None."""

    recording: TrackSeries
    """All of the recorded flight."""
    recorded: TrackSeries
    """What of it was flown again, or is planned to be."""
    planned_m: Floats
    waypoints_m: Floats
    waypoint_seqs: tuple[int, ...]
    planned_error: PathErrorSeries
    planned_height: tuple[Floats, Floats]
    """Times, and heights above home that the plan asks for."""
    time_label: str
    """What charts over time say of their time."""
    error_label: str
    """What those of errors say."""
    timed: bool = True
    """Whether the recording is; if not, charts over time show nothing but its errors."""
    home_m: Floats | None = None
    """North and east."""
    predicted: TrackSeries | None = None
    """Where the model flies it."""
    predicted_error: FlightErrorSeries = FlightErrorSeries()
    flown: TrackSeries | None = None
    flown_error: FlightErrorSeries = FlightErrorSeries()
    reached: tuple[tuple[float, float], ...] = ()
    """Time and planned altitude of each waypoint reached."""

    @property
    def predicted_unflown(self) -> TrackSeries | None:
        """What is predicted, as long as nothing is flown."""
        return self.predicted if self.flown is None else None

    @property
    def shown_error(self) -> FlightErrorSeries:
        """The errors that were flown, or else those that are predicted."""
        return self.predicted_error if self.flown is None else self.flown_error

    @property
    def recorded_lines(self) -> tuple[tuple[str, TrackSeries], ...]:
        """The recorded lines to draw, by their names: below, all that was recorded, unless all is covered."""
        whole, part = self.recording.time_s, self.recorded.time_s
        if len(part) and part[0] <= whole[0] and part[-1] >= whole[-1]:
            return (("recorded", self.recorded),)
        return ((NOT_COVERED, self.recording), ("recorded", self.recorded))

    @property
    def map_corners_m(self) -> Floats:
        """Two corners (2, 2), opposite each other, of what is on a map at least, around the recording."""
        places_m = self.recording.north_east_m
        middle_m = (places_m.min(axis=0) + places_m.max(axis=0)) / 2
        return np.vstack([middle_m - SMALLEST_MAP_M / 2, middle_m + SMALLEST_MAP_M / 2])

    @property
    def timed_lines(self) -> tuple[tuple[str, TrackSeries], ...]:
        """The recorded lines to draw over time."""
        return self.recorded_lines if self.timed else ()


def replay_series(route: Route, outcome: Outcome | None = None) -> ReplaySeries:
    """The series of a route, and of the flight that followed it if there was one."""
    frame, waypoints, home = route.frame, route.mission.waypoints, route.mission.home
    planned = route.path
    if route.reference is None:
        planned = path_through(destinations(route.mission.items, frame), tolerance_m=CURVE_TOLERANCE_M)
    else:
        waypoints = ()
    covered = slice(None if outcome is None else outcome.coverage.fixes)
    series = ReplaySeries(
        recording=_recorded_series(route, route.recording),
        recorded=_recorded_series(route, route.recorded, covered),
        planned_m=planned.north_east_m,
        waypoints_m=frame.to_metres(
            [item.lat_deg for _, item in waypoints], [item.lon_deg for _, item in waypoints]
        ),
        waypoint_seqs=tuple(seq for seq, _ in waypoints),
        planned_error=_path_error_series(route.planned_error),
        planned_height=_planned_height(route),
        time_label=time_label(route),
        error_label=time_label(route) if route.recording.timed else _UNTIMED_LABEL,
        timed=route.recording.timed,
        home_m=None if home is None else frame.to_metres(home.lat_deg, home.lon_deg),
        predicted=_predicted_series(route),
        predicted_error=_flight_error_series(route.predicted),
    )
    if outcome is None:
        return series
    record = outcome.record
    return replace(
        series,
        flown=_flown_series(route, record) if len(record.flown) else None,
        reached=_reached(route, record),
        flown_error=_flight_error_series(outcome.errors),
    )


def _flight_error_series(errors: FlightErrors | None) -> FlightErrorSeries:
    if errors is None:
        return FlightErrorSeries()
    return FlightErrorSeries(
        path=_path_error_series(errors.path_m) if len(errors.path_m.recorded_to_path) else None,
        position=_error_series(errors.position_m),
        height=_error_series(errors.height_m),
        heading=_error_series(errors.heading_deg),
    )


def _planned_height(route: Route) -> tuple[Floats, Floats]:
    """When the recording is at its fixes, and how high the plan has the vehicle there."""
    keep = thin_indices(len(route.wanted) if route.recording.timed else 0)
    return route.wanted.time_s[keep], route.planned_up_m[keep]


def _predicted_series(route: Route) -> TrackSeries | None:
    """Where the model flies, its speed that between two places."""
    flown = route.predicted_flight
    if flown is None or len(flown) < 2:
        return None
    keep = thin_indices(len(flown))
    places_m, time_s = flown.north_east_m[keep], flown.time_s[keep]
    steps_s = np.maximum(np.diff(time_s), 1e-3)
    speed_m_s = np.linalg.norm(np.diff(places_m, axis=0), axis=1) / steps_s
    return TrackSeries(places_m, time_s, flown.up_m[keep], np.append(speed_m_s[:1], speed_m_s))


def time_label(route: Route) -> str:
    """What charts of a route say of their time."""
    if not route.recording.timed:
        return "time since the first waypoint (s)"
    if route.reference is None:
        return "time since the first fix / first waypoint (s)"
    return (
        "time of the recording (s)" if route.pace == 1.0 else f"time of the recording at {route.pace:g}x (s)"
    )


def _flown_series(route: Route, record: FlightRecord) -> TrackSeries:
    """The flown track; where the recording was followed, by the reference's clock."""
    flown = record.flown
    if record.recording_s is None:
        times_s = flown.time_s - flown_start_s(route, record)
    else:
        flown, times_s = followed_part(flown, record.recording_s)
    return _track_series(flown, flown.north_east_m(route.frame), times_s)


def _reached(route: Route, record: FlightRecord) -> tuple[tuple[float, float], ...]:
    altitudes_m = {seq: item.alt_m for seq, item in route.mission.waypoints}
    start_s = flown_start_s(route, record)
    return tuple((time_s - start_s, altitudes_m[seq]) for seq, time_s in record.reached if seq in altitudes_m)


def _track_series(track: Track, north_east_m: Floats, time_s: Floats, pace: float = 1.0) -> TrackSeries:
    keep = thin_indices(len(track))
    speed_m_s = pace * ground_speed_m_s(track, north_east_m)
    return TrackSeries(north_east_m[keep], time_s[keep], track.alt_m[keep], speed_m_s[keep])


def _recorded_series(route: Route, track: Track, part: slice = slice(None)) -> TrackSeries:
    """A part of a recorded track; time counts from the track's first fix, at the route's pace."""
    kept = track.select(part)
    times_s = track.time_s - track.time_s[0] if route.reference is None else route.wanted.time_s
    return _track_series(kept, kept.north_east_m(route.frame), times_s[part], route.pace)


def _path_error_series(errors: PathErrors) -> PathErrorSeries:
    return PathErrorSeries(_error_series(errors.recorded_to_path), _error_series(errors.path_to_recorded))


def _error_series(errors: Errors) -> ErrorSeries | None:
    """The errors, thinned, in the order of time; None if there are none."""
    statistics = errors.statistics
    if statistics is None:
        return None
    keep = peak_indices(errors.error)
    return ErrorSeries(errors.time_s[keep], errors.error[keep], statistics)


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


def peak_indices(values: Floats) -> Indices:
    """At most ``MAX_CHART_POINTS`` indices: that of the highest value in each of so many equal parts."""
    if len(values) <= MAX_CHART_POINTS:
        return np.arange(len(values))
    edges = np.linspace(0, len(values), MAX_CHART_POINTS + 1).astype(np.intp)
    return np.array([a + int(np.argmax(values[a:b])) for a, b in pairwise(edges)])

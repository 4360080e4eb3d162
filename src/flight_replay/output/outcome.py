"""The errors of a replay: the flown track against the recorded fixes that it had to follow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.distances import (
    ErrorStatistics,
    error_statistics,
    path_errors_m,
    position_errors_m,
)
from flight_replay.geometry.matching import match_in_order
from flight_replay.logs.track import Track
from flight_replay.mission.path import Path
from flight_replay.planning.route import Route

if TYPE_CHECKING:
    from flight_replay.supervisor.flight_plan import FlightRecord

_TOLERANCE_M = 0.001


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """The errors of one replay, in metres.

    ``path_errors_m`` and ``position_errors_m`` have an error for each of the first fixes of the
    route's covered track: as many as the flight reached, and as many as both clocks cover.
    ``path_error`` and ``position_error`` summarise them, None where there is nothing to compare.
    """

    path_error: ErrorStatistics | None
    position_error: ErrorStatistics | None
    path_errors_m: Floats
    position_errors_m: Floats


def compare_flight(route: Route, record: FlightRecord) -> Outcome:
    """Path error and position error of a flight.

    A flight that ended before the final waypoint is compared only with the fixes that the route
    covers up to the last waypoint reached.
    """
    path_m = _path_errors_m(_fixes_reached(route, record), record.flown)
    position_m = _position_errors_m(route, record)
    return Outcome(error_statistics(path_m), error_statistics(position_m), path_m, position_m)


def _fixes_reached(route: Route, record: FlightRecord) -> Track:
    """The covered fixes up to the last waypoint that was reached."""
    reached = {seq for seq, _ in record.reached}
    last_seq = max((seq for seq, _ in route.mission.waypoints if seq in reached), default=0)
    if last_seq == route.mission.waypoints[-1][0]:
        return route.covered
    matching = match_in_order(route.covered.north_east_m(), route.path.north_east_m)
    return route.covered.select(matching.along_m <= _length_to_item_m(route.path, last_seq) + _TOLERANCE_M)


def _length_to_item_m(path: Path, seq: int) -> float:
    """Length of the path up to item ``seq``, metres; -1 before the first item."""
    steps_m = np.linalg.norm(np.diff(path.north_east_m, axis=0), axis=1)
    passed = np.flatnonzero(path.seq <= seq)
    return float(steps_m[: passed[-1]].sum()) if len(passed) else -1.0


def _path_errors_m(fixes: Track, flown: Track) -> Floats:
    if not len(fixes) or not len(flown):
        return np.zeros(0)
    frame = fixes.frame
    return path_errors_m(fixes.north_east_m(frame), flown.north_east_m(frame))


def _position_errors_m(route: Route, record: FlightRecord) -> Floats:
    """Errors at equal times: recorded time since the first fix, flown time since the first waypoint."""
    first_waypoint_s = dict(record.reached).get(route.mission.waypoints[0][0])
    if first_waypoint_s is None or not len(record.flown):
        return np.zeros(0)
    recorded, frame = route.covered, route.covered.frame
    return position_errors_m(
        recorded.time_s - recorded.time_s[0],
        recorded.north_east_m(frame),
        record.flown.time_s - first_waypoint_s,
        record.flown.north_east_m(frame),
    )

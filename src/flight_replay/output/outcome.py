"""How a replay went: the flown track against the recorded fixes that it should have followed."""

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

_ON_THE_SPOT_M = 0.001


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """Distances of one replay, metres; None where nothing can be compared.

    ``space_m`` and ``time_m`` hold a distance for each of the first fixes of the route's covered
    track: as many as the flight got to, and as many as both clocks have.
    """

    in_space: ErrorStatistics | None
    in_time: ErrorStatistics | None
    space_m: Floats
    time_m: Floats


def compare_flight(route: Route, record: FlightRecord) -> Outcome:
    """Measure a flight by DESIGN.md's measures.

    A flight that was ended before the final waypoint is held only to the fixes that the route
    covers up to the last waypoint reached.
    """
    due = _fixes_due(route, record)
    space_m = _distances_in_space(due, record.flown)
    time_m = _distances_in_time(route, record)
    return Outcome(error_statistics(space_m), error_statistics(time_m), space_m, time_m)


def _fixes_due(route: Route, record: FlightRecord) -> Track:
    """The covered fixes on the way to the last waypoint that was reached."""
    reached = {seq for seq, _ in record.reached}
    last_seq = max((seq for seq, _ in route.mission.waypoints if seq in reached), default=0)
    if last_seq == route.mission.waypoints[-1][0]:
        return route.covered
    matching = match_in_order(route.covered.north_east_m(), route.path.north_east_m)
    return route.covered.select(matching.along_m <= _reach_m(route.path, last_seq) + _ON_THE_SPOT_M)


def _reach_m(path: Path, seq: int) -> float:
    """Length of the path up to item ``seq``, metres; below zero before the first."""
    steps_m = np.linalg.norm(np.diff(path.north_east_m, axis=0), axis=1)
    behind = np.flatnonzero(path.seq <= seq)
    return float(steps_m[: behind[-1]].sum()) if len(behind) else -1.0


def _distances_in_space(due: Track, flown: Track) -> Floats:
    if not len(due) or not len(flown):
        return np.zeros(0)
    frame = due.frame
    return path_errors_m(due.north_east_m(frame), flown.north_east_m(frame))


def _distances_in_time(route: Route, record: FlightRecord) -> Floats:
    """Recorded positions since the first fix against flown ones since the first waypoint."""
    reached_s = dict(record.reached).get(route.mission.waypoints[0][0])
    if reached_s is None or not len(record.flown):
        return np.zeros(0)
    recorded, frame = route.covered, route.covered.frame
    return position_errors_m(
        recorded.time_s - recorded.time_s[0],
        recorded.north_east_m(frame),
        record.flown.time_s - reached_s,
        record.flown.north_east_m(frame),
    )

"""From a recorded track to the route that will be flown, and how well that follows the recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from flight_replay.geometry.distances import ErrorStatistics, error_statistics
from flight_replay.geometry.matching import match_in_order
from flight_replay.logs.track import Track
from flight_replay.mission.items import Mission
from flight_replay.mission.path import Path, planned_path
from flight_replay.planning.duration import duration_s

_PIECE_M = 0.5
"""Pieces of path that are short enough for a planned error: 1 mm off on average, at a third of the time."""


@dataclass(frozen=True, slots=True)
class PredictedErrors:
    """Path error and position error, metres, of the route as the model of ArduCopter flies it."""

    path_error: ErrorStatistics
    position_error: ErrorStatistics


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """A mission, the recorded fixes that it covers, and what is known of it before it is flown.

    ``planned_error`` is the path error of the mission's path, ``predicted_duration_s`` the time in
    AUTO, ``predicted`` the errors of the flight where the planning simulated it. ``required_limits``
    are the fields of ``Limits`` to raise on the vehicle before it flies, in SI units; ``notes`` are
    sentences for people.
    """

    method: str
    mission: Mission
    covered: Track
    path: Path
    planned_error: ErrorStatistics
    predicted_duration_s: float
    predicted: PredictedErrors | None = None
    required_limits: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def route_of(method: str, mission: Mission, covered: Track) -> Route:
    """The route of a mission that was made from ``covered``, with its planned error.

    Args:
        method: how the mission was made, by its name.
        mission: at least one waypoint.
        covered: at least one fix.
    """
    path = planned_path(mission, covered.frame)
    matching = match_in_order(covered.north_east_m(), path.north_east_m, _PIECE_M)
    error = error_statistics(matching.distance_m)
    assert error is not None, "a covered track has fixes"
    return Route(method, mission, covered, path, error, duration_s(mission, path))

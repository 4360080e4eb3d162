"""The points of a draft's flight whose errors count, and how those change as the flight there moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import lengths_m, nearest_on_segments
from flight_replay.planning.fit.lateness import places_at
from flight_replay.planning.fit.legs.local_flights import LocalFlight
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.offsets import marks_along, pieces_around
from flight_replay.planning.fit.problem import FitProblem

_AROUND_S = 0.1
"""Ways are those from so long before to so long after."""
_SAME_S = 1e-6
"""Times that differ by less are one: steps of the model and fixes often are at the same but for last bits."""
_ACROSS_SHARE, _ACROSS_M = 0.3, 0.02
"""An error that points along the path by more than this is one from an end or a corner of it."""


@dataclass(frozen=True, slots=True, eq=False)
class FlightPoints:
    """Some kind of points of a flight: when it is there, rising (k,), and where that is (k, 2).

    ``along`` (k, 2) are unit vectors along which a point may move without a change of its error, zero where
    there is no such way. ``row`` is where their errors begin among those of all kinds.
    """

    row: int
    time_s: Floats
    place_m: Floats
    along: Floats

    def between(self, begin_s: float, end_s: float) -> slice:
        """Which of them the vehicle passes between two times."""
        begin, end = np.searchsorted(self.time_s, [begin_s - _SAME_S, end_s - _SAME_S]).tolist()
        return slice(begin, end)

    def across(self, moves_m: Floats, some: slice) -> Floats:
        """What is left of moves (k, 2) of some of the points that changes their errors."""
        along = self.along[some]
        return np.asarray(moves_m - along * (moves_m * along).sum(axis=1, keepdims=True))


def points_at_fixes(problem: FitProblem, flight: LocalFlight) -> FlightPoints:
    """Where the vehicle is at the time of each fix; all of such an error counts."""
    time_s = problem.recording.time_s
    return FlightPoints(0, time_s, _places_m(flight, time_s), np.zeros((len(time_s), 2)))


def points_beside_fixes(base: Evaluation, flight: LocalFlight, row: int) -> FlightPoints:
    """Where the vehicle flies by each fix, as it was evaluated."""
    time_s, off_m = np.maximum.accumulate(base.flown_s), base.flown[0].off_m
    ways = _unit(_places_m(flight, time_s + _AROUND_S) - _places_m(flight, time_s - _AROUND_S))
    return FlightPoints(row, time_s, _places_m(flight, time_s), _free_ways(ways, off_m))


def marks_of_flight(problem: FitProblem, base: Evaluation, flight: LocalFlight, row: int) -> FlightPoints:
    """The points of the flown path that are compared with the recorded line, as it was evaluated."""
    marks_m, time_s = marks_along(base.flight, problem.recording.axes)
    fixes, off_m = problem.recording.north_east_m, base.flown[1].off_m
    following = np.searchsorted(np.maximum.accumulate(base.flown_s), time_s)
    around = pieces_around(following, len(fixes))
    steps = np.diff(fixes, axis=0)
    _, apart = nearest_on_segments((marks_m + off_m)[:, None], fixes[around], steps[around])
    ways = _unit(steps[around[np.arange(len(marks_m)), apart.argmin(axis=1)]])
    return FlightPoints(row, time_s, _places_m(flight, time_s), _free_ways(ways, off_m))


def _places_m(flight: LocalFlight, time_s: Floats) -> Floats:
    return places_at(flight.time_s, flight.north_east_m, time_s)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(lengths_m(vectors)[:, None], 1e-9))


def _free_ways(ways: Floats, off_m: Floats) -> Floats:
    """The unit vectors along a path (k, 2) where errors (k, 2) are across it; zero at the other points."""
    along_m = np.abs((off_m * ways).sum(axis=1, keepdims=True))
    apart_m = lengths_m(off_m)[:, None]
    return np.where(along_m <= _ACROSS_SHARE * apart_m + _ACROSS_M, ways, 0.0)

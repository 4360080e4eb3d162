"""How far a flight, or a path, is from a recording: the measures that docs/measures.md explains.

The path error counts both ways: an overshoot is far from the recorded line, though the path that
overshoots passes every fix closely. The others compare the two vehicles at equal times.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.geometry.error_statistics import ErrorStatistics, error_statistics
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.movement import Movement, turn_deg
from flight_replay.geometry.polyline import lengths_along_m

PLACE_SPACING_M = 0.25
"""A path is measured from the recorded line about this often."""
MAX_PLACES = 100_000
"""Paths that are too long for so many places are measured less often."""
_PIECE_M = 0.25  # Pieces of path that are short enough: less than a millimetre off on average.


@dataclass(frozen=True, slots=True, eq=False)
class Errors:
    """Errors (n,), metres or degrees, and the times (n,) that they belong to, seconds."""

    time_s: Floats
    error: Floats

    def __len__(self) -> int:
        return len(self.error)

    @property
    def statistics(self) -> ErrorStatistics | None:
        """Mean, 95th percentile and maximum; None when there is no error."""
        return error_statistics(self.error)

    def between(self, first_s: float, last_s: float) -> Errors:
        """Those at the times from ``first_s`` to ``last_s``."""
        keep = (self.time_s >= first_s) & (self.time_s <= last_s)
        return Errors(self.time_s[keep], self.error[keep])


@dataclass(frozen=True, slots=True, eq=False)
class PathErrors:
    """The path error both ways, metres: of the recorded fixes from a path, and of the path's places.

    Times are the recording's; ``place_m`` (m, 2) are the places on the path.
    """

    recorded_to_path: Errors
    path_to_recorded: Errors
    place_m: Floats

    def between(self, first_s: float, last_s: float) -> PathErrors:
        """Those of the fixes and places at the recorded times from ``first_s`` to ``last_s``."""
        matched_s = self.path_to_recorded.time_s
        return PathErrors(
            self.recorded_to_path.between(first_s, last_s),
            self.path_to_recorded.between(first_s, last_s),
            self.place_m[(matched_s >= first_s) & (matched_s <= last_s)],
        )


@dataclass(frozen=True, slots=True, eq=False)
class FlightErrors:
    """All errors of a flight: the path error both ways, and those at equal times.

    ``position_m`` and ``height_m`` are metres, ``heading_deg`` degrees from 0 to 180.
    """

    path_m: PathErrors
    position_m: Errors
    height_m: Errors
    heading_deg: Errors

    def between(self, first_s: float, last_s: float) -> FlightErrors:
        """Those at the recorded times from ``first_s`` to ``last_s``."""
        at_equal_times = (self.position_m, self.height_m, self.heading_deg)
        return FlightErrors(
            self.path_m.between(first_s, last_s),
            *(errors.between(first_s, last_s) for errors in at_equal_times),
        )


NO_ERRORS = Errors(np.zeros(0), np.zeros(0))


def path_errors(
    fixes: Movement, path_m: Floats, line: Movement | None = None, places_m: Floats | None = None
) -> PathErrors:
    """The path error both ways; none where there is no fix or no path.

    Args:
        fixes: the recorded fixes that the path has to pass.
        path_m: the path (k, 2) that they are matched to.
        line: the recorded line that the path's places are matched to; ``fixes`` if None.
        places_m: the line (l, 2) along which places are measured; the path itself if None.
    """
    line = fixes if line is None else line
    places = spaced_places_m(path_m if places_m is None else places_m)
    to_path, to_recorded, matched_s = NO_ERRORS, NO_ERRORS, np.zeros(0)
    if len(fixes) and len(path_m):
        to_path = Errors(fixes.time_s, match_in_order(fixes.north_east_m, path_m, _PIECE_M).distance_m)
    if len(line) and len(places):
        back = match_in_order(places, line.north_east_m, _PIECE_M)
        matched_s = np.interp(back.along_m, lengths_along_m(line.north_east_m), line.time_s)
        to_recorded = Errors(matched_s, back.distance_m)
    return PathErrors(to_path, to_recorded, places[: len(to_recorded)])


def spaced_places_m(line_m: Floats) -> Floats:
    """Places (m, 2) at equal distances along a line (k, 2), both ends included."""
    if not len(line_m):
        return np.zeros((0, 2))
    along = lengths_along_m(line_m)
    count = min(int(np.ceil(along[-1] / PLACE_SPACING_M)) + 1, MAX_PLACES)
    where = np.linspace(0.0, along[-1], count)
    return np.column_stack([np.interp(where, along, axis) for axis in line_m.T])


def errors_at_equal_times(recorded: Movement, flown: Movement) -> tuple[Errors, Errors, Errors]:
    """Position error, height error and heading error at the recorded times that the flight has too.

    A fix whose height or heading is unknown, on either side, has no such error; without recorded times
    there is none at all.
    """
    if not (len(recorded) and len(flown) and recorded.timed and flown.timed):
        return NO_ERRORS, NO_ERRORS, NO_ERRORS
    both = recorded.select((recorded.time_s >= flown.time_s[0]) & (recorded.time_s <= flown.time_s[-1]))
    off_m = both.north_east_m - flown.places_at(both.time_s)
    height_m = np.abs(both.up_m - np.interp(both.time_s, flown.time_s, flown.up_m))
    off_deg = np.abs(turn_deg(flown.headings_at(both.time_s), both.heading_deg))
    heights, headings = np.isfinite(height_m), np.isfinite(off_deg)
    return (
        Errors(both.time_s, np.hypot(off_m[:, 0], off_m[:, 1])),
        _known(both.time_s, height_m, heights),
        _known(both.time_s, off_deg, headings),
    )


def _known(time_s: Floats, error: Floats, known: Flags) -> Errors:
    return Errors(time_s[known], error[known])


def flight_errors(
    recorded: Movement,
    flown: Movement,
    *,
    last_s: float = np.inf,
    fixes: int | None = None,
    line: int | None = None,
) -> FlightErrors:
    """The errors of a flight, whose times count from when its first waypoint was reached.

    Args:
        recorded: what it had to follow, its times counting from its first fix.
        flown: where the vehicle was.
        last_s: when it reached its last waypoint.
        fixes: so many of the first fixes it was to pass by then; all if None.
        line: so many of the first fixes make the line that its path is measured from; all if None.
    """
    between = flown.select((flown.time_s >= 0.0) & (flown.time_s <= last_s))
    path = path_errors(
        recorded.select(slice(fixes)),
        flown.north_east_m,
        recorded.select(slice(line)),
        places_m=between.north_east_m,
    )
    return FlightErrors(path, *errors_at_equal_times(recorded, flown))

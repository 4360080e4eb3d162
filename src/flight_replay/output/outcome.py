"""How a flight went: how much of the recording it covered, and its errors against that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.flight_errors import FlightErrors, flight_errors
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.polyline import lengths_along_m
from flight_replay.logs.track import Track
from flight_replay.planning.route import Route, movement_of

if TYPE_CHECKING:
    from flight_replay.supervisor.flight_plan import FlightRecord

_TOLERANCE_M = 0.001
_BEYOND_M = 5.0
"""So much recorded line beyond the last waypoint is measured from: vehicles report a waypoint behind it."""


@dataclass(frozen=True, slots=True)
class Coverage:
    """Which part of the recorded flight was flown again: fixes and seconds, and how many there are.

    ``recorded_s`` runs to the last fix that was reached; ``fly_all`` are the options with which all of
    it is flown, none where all of it was. Of a recording that is not ``timed`` the seconds mean nothing.
    """

    fixes: int
    of_fixes: int
    recorded_s: float
    of_recorded_s: float
    fly_all: tuple[str, ...]
    timed: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """A flight, its ``record`` beside the recording.

    ``first_waypoint_s`` is when, by the vehicle's clock, it reached the first waypoint, which the
    recording's first fix is put on for errors at equal times; None if it never did. ``waited_s`` is how
    long the recording waited for a vehicle that followed it; None for a mission, which does not wait.
    """

    record: FlightRecord
    errors: FlightErrors
    coverage: Coverage
    first_waypoint_s: float | None
    waited_s: float | None = None

    @property
    def not_measured(self) -> Mapping[str, str]:
        """Why there is no error of a kind: the kind's name in ``--json``, and the reason."""
        errors, point = self.errors, "waypoint" if self.waited_s is None else "fix"
        no_time = None if len(errors.position_m) else "there is no time that both flights have"
        if not self.coverage.timed:
            no_time = "the recording has no times"
        reasons = {
            "path_error_m": self._no_path_error(point),
            "position_error_m": no_time,
            "height_error_m": no_time or "the recording has no height at times that both have",
            "heading_error_deg": no_time or "one of both flights has no heading",
        }
        to_path, back = errors.path_m.recorded_to_path, errors.path_m.path_to_recorded
        counts = {
            "path_error_m": min(len(to_path), len(back)),
            "position_error_m": len(errors.position_m),
            "height_error_m": len(errors.height_m),
            "heading_error_deg": len(errors.heading_deg),
        }
        never = f"the first {point} was not reached"
        return {
            name: never if self.first_waypoint_s is None else str(reasons[name])
            for name, count in counts.items()
            if not count
        }

    def _no_path_error(self, point: str) -> str:
        """Why there is no path error, or none from flown to recorded."""
        if len(self.errors.path_m.recorded_to_path):
            return f"flown to recorded: no position between the first {point} and the last one reached"
        return f"no position was received {'in AUTO' if self.waited_s is None else 'while following'}"


def compare_flight(route: Route, record: FlightRecord) -> Outcome:
    """The errors of a flight, and what it covered.

    A flight that ended before the final waypoint is compared only with what the route covers up to
    the last waypoint reached.
    """
    if record.recording_s is not None:
        return _compare_following(route, record, record.recording_s)
    reached_s = dict(record.reached)
    passed = [reached_s[seq] for seq, _ in route.mission.waypoints if seq in reached_s]
    first_s = reached_s.get(route.mission.waypoints[0][0])
    start_s = flown_start_s(route, record)
    fixes, line = _fixes_reached(route, record)
    flown = movement_of(record.flown, route.frame, start_s)
    errors = flight_errors(
        route.wanted,
        flown if first_s is not None else flown.select(slice(0)),
        last_s=passed[-1] - start_s if passed else 0.0,
        fixes=fixes,
        line=line,
    )
    return Outcome(record, errors, _coverage(route, fixes), first_s)


def flown_start_s(route: Route, record: FlightRecord) -> float:
    """The vehicle's time when it reached the first waypoint, or when AUTO began if it never did."""
    return dict(record.reached).get(route.mission.waypoints[0][0], record.auto_start_s)


def _compare_following(route: Route, record: FlightRecord, recording_s: Floats) -> Outcome:
    """The errors of a flight that followed the recording, by the reference's clock.

    What the vehicle's clock is ahead of the reference's in the end, the recording waited for it.
    """
    known = np.isfinite(recording_s)
    late_s = (record.flown.time_s - recording_s)[known & (recording_s >= 0.0)]
    flown, recording_s = followed_part(record.flown, recording_s)
    movement = replace(movement_of(flown, route.frame), time_s=recording_s)
    end_s = float(recording_s.max(initial=0.0))
    fixes = _count_up_to(route.wanted.time_s, end_s)
    # The vehicle may be on its way to the next fix: its path is measured from the line to that one too.
    last_s = min(end_s, float(route.wanted.time_s[-1]))
    errors = flight_errors(route.wanted, movement, last_s=last_s, fixes=fixes, line=fixes + 1)
    begun_s = (flown.time_s - recording_s)[recording_s >= 0.0]
    return Outcome(
        record,
        errors,
        _coverage(route, fixes),
        float(begun_s[0]) if len(begun_s) else None,
        waited_s=max(float(late_s[-1] - late_s[0]), 0.0) if len(late_s) else 0.0,
    )


def followed_part(flown: Track, recording_s: Floats) -> tuple[Track, Floats]:
    """What of a flown track (n,) counts as following, and the recording's time at each of its positions.

    Where the reference went back to a vehicle that had lost it, the second time over counts.
    """
    known = np.isfinite(recording_s)
    flown, recording_s = flown.select(known), recording_s[known]
    latest_s = np.minimum.accumulate(recording_s[::-1])[::-1]
    kept = recording_s <= latest_s
    return flown.select(kept), recording_s[kept]


def _coverage(route: Route, fixes: int) -> Coverage:
    """How much the first fixes of what the route covers are of all that was recorded."""
    of_fixes, last = len(route.recording), len(route.wanted)
    fly_all = ("--route fit",) if last < of_fixes else ()
    if fixes < of_fixes:
        fly_all = (*fly_all, "--duration all")
    return Coverage(
        fixes=fixes,
        of_fixes=of_fixes,
        recorded_s=float(route.recorded.time_s[fixes - 1] - route.recorded.time_s[0]) if fixes else 0.0,
        of_recorded_s=float(route.recording.time_s[-1] - route.recording.time_s[0]),
        fly_all=fly_all,
        timed=route.recording.timed,
    )


def _fixes_reached(route: Route, record: FlightRecord) -> tuple[int, int]:
    """How many of the fixes lie before the last waypoint that was reached, and a little beyond it.

    In space, as a climb on the spot has no length over the ground.
    """
    reached = {seq for seq, _ in record.reached}
    last_seq = max((seq for seq, _ in route.mission.waypoints if seq in reached), default=0)
    if last_seq == route.mission.waypoints[-1][0]:
        return len(route.wanted), len(route.wanted)
    path_m = np.column_stack([route.path.north_east_m, route.path.up_m])
    fixes_m = np.column_stack([route.wanted.north_east_m, route.planned_up_m])
    along_m = match_in_order(fixes_m, path_m).along_m
    end_m = _length_to_item_m(path_m, route.path.seq, last_seq)
    if end_m < 0:
        return 0, 0
    return _count_up_to(along_m, end_m + _TOLERANCE_M), _count_up_to(along_m, end_m + _BEYOND_M)


def _count_up_to(along_m: Floats, end_m: float) -> int:
    return int(np.searchsorted(along_m, end_m, side="right"))


def _length_to_item_m(path_m: Floats, seqs: Indices, seq: int) -> float:
    """Length of a path (m, 3) up to item ``seq``, metres; -1 before the first item of its points (m,)."""
    passed = np.flatnonzero(seqs <= seq)
    return float(lengths_along_m(path_m)[passed[-1]]) if len(passed) else -1.0

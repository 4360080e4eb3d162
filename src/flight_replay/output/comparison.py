"""Two recordings of one motion compared: a replay with what it replayed, or two replays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from flight_replay.exceptions import LogError
from flight_replay.flight_modes import CopterMode
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flight_errors import FlightErrors, errors_at_equal_times, flight_errors
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.movement import Movement
from flight_replay.geometry.polyline import lengths_along_m
from flight_replay.logs.flights import select
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import Track
from flight_replay.planning.flown_part import flown_part
from flight_replay.planning.route import movement_of

_END_M = 1.0
"""Beyond this distance from its ends a track covers another one; within, both may hover."""
_PASSING_S = 2.0
"""So far may the moment be off at which a fix is passed: at walking pace, by a metre or two beside it."""
_NEAR_M = 3.0
"""While a flight is so near to a fix, as one that creeps off, any moment may be that at which it passes."""
_NEAR_STEP_S, _MOST_STEPS = 0.5, 1000
_MUCH_NEARER = 0.5
"""Such a moment counts if it makes the mean distance less than this share: then both keep one time."""
_ELSEWHERE_M = 100.0
"""Tracks that never come closer than this are not of one motion."""


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """The errors of the second motion against the first, of which ``fixes`` were covered."""

    errors: FlightErrors
    fixes: int


def compare_tracks(
    first: Track, second: Track, from_s: float | None = None, to_s: float | None = None
) -> Comparison:
    """The errors of the second track, over what it covers of the first, between two times of that.

    Its clock is put on the first one's where it passes the first fix that it covers, give or take what
    makes the mean position error least. Both are of all that it covers, whatever the times wanted.

    Args:
        first: what was to be flown.
        second: what flew it.
        from_s: first second of the first track that is measured, counted from its first fix.
        to_s: last second, counted likewise.

    Raises:
        LogError: One of them does not move, the second does not follow the first, or not between the times.
    """
    for name, track in (("first", first), ("second", second)):
        if not _moves(track):
            raise LogError(f"the {name} recording does not move over the ground; name another to compare")
    recorded, flown = movement_of(first, first.frame), movement_of(second, first.frame)
    wanted = select(first, None, from_s, to_s)
    wanted_s = wanted.time_s[[0, -1]] - first.time_s[0]
    if len(wanted) < len(first):
        recorded = _searched(recorded, flown, wanted_s)
    recorded, passed_s = _covered(_reached(recorded, flown), flown)
    covered_s = recorded.time_s[[0, -1]]
    errors = _errors(recorded, flown, passed_s).between(*(wanted_s - covered_s[0]))
    fixes = len(errors.path_m.recorded_to_path)
    if not fixes:
        times = f"from {covered_s[0]:.1f} to {covered_s[1]:.1f} s"
        raise LogError(f"the second recording follows the first {times}; choose --from and --to there")
    return Comparison(errors, fixes)


def _covered(recorded: Movement, flown: Movement) -> tuple[Movement, Floats]:
    """What of a recording a flight covers, and when (2,) it passes the first and the last fix of that."""
    matching = match_in_order(recorded.north_east_m, flown.north_east_m)
    along_m = matching.along_m
    lengths_m = lengths_along_m(flown.north_east_m)
    covered = np.flatnonzero((along_m > _END_M) & (along_m < lengths_m[-1] - _END_M))
    if len(covered) < 2 or matching.distance_m.min() > _ELSEWHERE_M:
        raise LogError("the second recording does not follow the first; name another to compare")
    # Where the track stands, lengths are equal: the last time there is when it goes on.
    passed_s = np.interp(along_m[covered[[0, -1]]], lengths_m + 1e-9 * np.arange(len(flown)), flown.time_s)
    return recorded.select(slice(int(covered[0]), int(covered[-1]) + 1)), passed_s


def _errors(recorded: Movement, flown: Movement, passed_s: Floats) -> FlightErrors:
    """The errors of a flight that passes the first and the last fix at two times (2,) of its own clock."""
    recorded = replace(recorded, time_s=recorded.time_s - recorded.time_s[0])
    flown = replace(flown, time_s=flown.time_s - passed_s[0])
    errors = flight_errors(recorded, flown, last_s=float(passed_s[1] - passed_s[0]))
    aligned = replace(flown, time_s=flown.time_s - _late_s(recorded, flown))
    position_m, height_m, heading_deg = errors_at_equal_times(recorded, aligned)
    return replace(errors, position_m=position_m, height_m=height_m, heading_deg=heading_deg)


def _late_s(recorded: Movement, flown: Movement) -> float:
    """How late a flight is by the clock of a recording whose first fix it passes: the mean distance is least.

    Within ``_PASSING_S``, or for as long as the flight is near that fix where that is much nearer.
    """

    def mean_m(late_s: float) -> float:
        off_m = recorded.north_east_m - flown.places_at(recorded.time_s + late_s)
        return float(np.hypot(off_m[:, 0], off_m[:, 1]).mean())

    def least_s(first_s: float, last_s: float) -> float:
        bounds = (first_s, last_s)
        return float(minimize_scalar(mean_m, bounds=bounds, method="bounded", options={"xatol": 1e-4}).x)

    first_s, last_s = _passing_s(recorded, flown)
    steps = min(int(np.ceil((last_s - first_s) / _NEAR_STEP_S)), _MOST_STEPS)
    tried_s, step_s = np.linspace(first_s, last_s, steps + 1, retstep=True)
    best_s = float(tried_s[np.argmin([mean_m(late_s) for late_s in tried_s.tolist()])])
    narrow_s = least_s(-_PASSING_S, _PASSING_S)
    wide_s = least_s(best_s - float(step_s), best_s + float(step_s))
    return wide_s if mean_m(wide_s) < _MUCH_NEARER * mean_m(narrow_s) else narrow_s


def _passing_s(recorded: Movement, flown: Movement) -> tuple[float, float]:
    """From when to when a flight may pass a recording's first fix, which it does at about 0 of its clock."""
    off_m = np.hypot(*(flown.north_east_m - recorded.north_east_m[0]).T)
    far_s = flown.time_s[off_m > _NEAR_M]
    before_s, after_s = far_s[far_s < 0.0], far_s[far_s >= 0.0]
    begin_s = before_s[-1] if len(before_s) else flown.time_s[0]
    end_s = after_s[0] if len(after_s) else flown.time_s[-1]
    return float(min(begin_s, 0.0)) - _PASSING_S, float(max(end_s, 0.0)) + _PASSING_S


def _searched(recorded: Movement, flown: Movement, wanted_s: Floats) -> Movement:
    """Where a flight is looked for: between two times (2,) if it lies there alone, which tells laps apart."""
    part = recorded.select((recorded.time_s >= wanted_s[0]) & (recorded.time_s <= wanted_s[1]))
    apart_m, part_m = (
        float(match_in_order(flown.north_east_m, line.north_east_m).distance_m.mean())
        for line in (recorded, part)
    )
    return part if part_m < apart_m + _END_M else recorded


def _reached(recorded: Movement, flown: Movement) -> Movement:
    """What of a recording a flight goes along, which may end long before it or after it, or begin elsewhere.

    Matched with a recording that ends first, the rest of a flight is drawn to one of its places, and what is
    before with it; but all of that recording has counterparts in the flight.
    """
    matching = match_in_order(flown.north_east_m, recorded.north_east_m)
    other_way = match_in_order(recorded.north_east_m, flown.north_east_m)
    if other_way.distance_m.mean() < matching.distance_m.mean():
        return recorded
    along_m = matching.along_m
    lengths_m = lengths_along_m(recorded.north_east_m)
    first = int(np.searchsorted(lengths_m, along_m[0], "left"))
    return recorded.select(slice(first, int(np.searchsorted(lengths_m, along_m[-1], "right"))))


def part_in(recording: Recording, modes: Sequence[CopterMode]) -> tuple[Track, str]:
    """The part of a recording in the first of some modes in which it moves, else its flights; which it is.

    A pilot's flight that a program took off may have been in GUIDED for that alone.
    """
    track = recording.track
    if recording.modes is not None:
        for mode in modes:
            flown = track.select(recording.modes == mode)
            if _moves(flown):
                return flown, f"its {mode.name} part"
    return flown_part(track)[0], "what was flown"


def _moves(track: Track) -> bool:
    """Whether a track leads anywhere over the ground."""
    return len(track) > 1 and bool(np.ptp(track.north_east_m(), axis=0).max() >= _END_M)

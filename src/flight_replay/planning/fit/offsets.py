"""Where fixes are beside a planned or flown path, and its own points beside the recorded line.

Fixes are matched to a path in order; each point of the path is compared with the recorded line around the
fixes that are matched there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.polyline import (
    lengths_along_m,
    lengths_m,
    nearest_on_segments,
    segment_lengths_m,
)
from flight_replay.planning.fit.basis import weights
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.reference import LocalTrack
from flight_replay.planning.fit.simulated_draft import SimulatedDraft

CURVE_TOLERANCE_M = 0.02
"""How well curves are drawn while fitting; the planned error of the answer is measured finer."""
_SPACING_M = 0.25
_BACK_SPACING_M = 0.5
_EVERY = round(_BACK_SPACING_M / _SPACING_M)
_PIECE_M = 1.0
_APART_SHARE, _FLIGHT_NEAR_M, _PLAN_NEAR_M = 1.5, 4.0, 6.0
"""A vehicle flies by a fix about so many times as far along its path as it is from the fix at its time."""
_VERY_LATE_M = 20.0
"""One that is so far from a fix may be whole turns behind, which its distance does not tell."""
_BESIDE_PLAN_M = 12.0
"""A vehicle at 10 m/s passes a place so far before or after its target is there."""
_NUDGE = 0.01
_WINDOW_FIXES = 4
"""A point of the path that lies between two fixes in order is compared with the line so many fixes around."""


@dataclass(frozen=True, slots=True, eq=False)
class Offsets:
    """Vectors ``off_m`` (m, 2) from m points of a path to the recording, and where those points are.

    ``leg`` (m,) is the place that each is on the way to, ``part`` (m,) how far, 0 to 1 in the curve's own
    parameter, of the planned path.
    """

    leg: Indices
    part: Floats
    off_m: Floats

    @property
    def apart_m(self) -> Floats:
        """Lengths (m,) of the vectors."""
        return lengths_m(self.off_m)

    @property
    def progress(self) -> Floats:
        """How far along the path they are (m,), leg and part as one number: k where k legs are flown."""
        return self.leg + self.part

    def passing_s(self, places: int, time_s: Floats) -> Floats:
        """When each of so many places (n,) is passed, if it is at those times (m,) at the points."""
        progress = np.maximum.accumulate(self.progress) + 1e-9 * np.arange(len(self.leg))
        return np.interp(np.arange(1, places + 1), progress, time_s)


@dataclass(frozen=True, slots=True, eq=False)
class MatchedFlight:
    """A flight beside a recording's n fixes: ``flown_s`` (n,) is when the vehicle flies by each.

    ``planned`` and ``flown`` are each the offsets of both ways: of the fixes, and of the path's own points.
    """

    planned: tuple[Offsets, Offsets]
    flown: tuple[Offsets, Offsets]
    flown_s: Floats


def match_to_flight(flight: SimulatedDraft, recording: LocalTrack, apart_m: Floats | None) -> MatchedFlight:
    """The offsets of a flight and of its planned path.

    A point of the flight belongs to where the plan has the fixes that the vehicle flies by there.

    Args:
        flight: in the metres of the recording.
        recording: at least one fix.
        apart_m: how far the vehicle is from each fix (n,) at its time: unless it is very late, it is searched
            around there first, or else around where the plan has the fix.
    """
    drawn = _DrawnFlight.of(flight, recording.axes)
    if apart_m is None or apart_m.max() > _VERY_LATE_M:
        planned = match_to_plan(flight.draft, recording)
        near_m = drawn.near_plan_m(flight.passed_s, planned[0])
        feet = _matched_points(recording.places_m, drawn.line_m, near_m)
    else:
        feet = _matched_points(recording.places_m, drawn.line_m, drawn.near_m(recording.time_s, apart_m))
        planned = match_to_plan(flight.draft, recording, drawn.progress(flight.passed_s, feet))
    flown_s = drawn.times_s(feet)
    marks, marks_s = drawn.line_m[::_EVERY], drawn.time_s[::_EVERY]
    order = np.maximum.accumulate(flown_s)
    back = _offsets_back(marks[:, :2], np.searchsorted(order, marks_s), recording)
    progress = np.maximum.accumulate(planned[0].progress)
    rising_s = order + 1e-6 * np.arange(len(order))
    where = _leg_and_part(np.interp(marks_s, rising_s, progress), len(flight.draft))
    there = Offsets(planned[0].leg, planned[0].part, recording.north_east_m - feet[0][:, :2])
    return MatchedFlight(planned, (there, Offsets(*where, back)), flown_s)


def match_to_plan(
    draft: Draft, recording: LocalTrack, likely: Floats | None = None
) -> tuple[Offsets, Offsets]:
    """The offsets of the fixes from the planned path, and those of the planned path from the fixes' line.

    Args:
        draft: whose path it is.
        recording: at least one fix.
        likely: about where on the path each fix is (n,), as ``Offsets.progress``: it is searched around there
            first.
    """
    path = draft.path(CURVE_TOLERANCE_M)
    line = np.column_stack([path.north_east_m, path.up_m])[:, : recording.axes]
    counts = np.bincount(path.seq, minlength=len(draft))
    begins = np.cumsum(counts) - counts
    near_m = None
    if likely is not None:
        at_places_m = lengths_along_m(line)[np.maximum(begins + counts, 1) - 1]
        likely_m = np.interp(likely, np.arange(1, len(draft) + 1), at_places_m)
        near_m = likely_m - _PLAN_NEAR_M, likely_m + _PLAN_NEAR_M
    foot, piece, share = _matched_points(recording.places_m, line, near_m)
    # Point p of the path is the end of step p - begins of its leg.
    progress = path.seq + np.clip((np.arange(len(line)) + 1 - begins[path.seq]) / counts[path.seq], 0.0, 1.0)
    ends = np.minimum(piece + 1, len(line) - 1)
    here = np.where(path.seq[ends] == path.seq[piece], progress[piece], path.seq[ends])
    here = here + share * (progress[ends] - here)
    marks, at = points_along(line, _BACK_SPACING_M)
    order = np.maximum.accumulate(here)
    mark_progress = np.interp(at, np.arange(len(line)), progress)
    back = _offsets_back(marks[:, :2], np.searchsorted(order, mark_progress), recording)
    return (
        Offsets(*_leg_and_part(here, len(draft)), recording.north_east_m - foot[:, :2]),
        Offsets(*_leg_and_part(mark_progress, len(draft)), back),
    )


def directions(draft: Draft, offsets: Offsets) -> Floats:
    """Unit vectors (m, 2) along the planned path at the points of some offsets."""
    ahead, behind = np.minimum(offsets.part + _NUDGE, 1.0), np.maximum(offsets.part - _NUDGE, 0.0)
    rows = weights(draft, offsets.leg, ahead) - weights(draft, offsets.leg, behind)
    direction = rows @ draft.places_m[:, :2]
    return np.asarray(direction / np.maximum(lengths_m(direction)[:, None], 1e-9))


def _leg_and_part(progress: Floats, legs: int) -> tuple[Indices, Floats]:
    """Legs and parts of them from both together."""
    leg = np.clip(np.ceil(progress).astype(np.intp) - 1, 0, legs - 1)
    return leg, np.clip(progress - leg, 0.0, 1.0)


_Feet = tuple[Floats, Indices, Floats]
"""Matched places (n, d) on a line, the piece of each, and how far along the piece, 0 to 1."""


@dataclass(frozen=True, slots=True, eq=False)
class _DrawnFlight:
    """Points ``line_m`` (k, axes) evenly along a flight, their times (k,), and the length up to each (k,)."""

    line_m: Floats
    time_s: Floats
    along_m: Floats

    @classmethod
    def of(cls, flight: SimulatedDraft, axes: int) -> _DrawnFlight:
        """The line of a flight."""
        line_m, at = points_along(flight.place_m[:, :axes], _SPACING_M)
        time_s = np.interp(at, np.arange(len(flight.time_s)), flight.time_s)
        return cls(line_m, time_s, lengths_along_m(line_m))

    def near_m(self, time_s: Floats, apart_m: Floats) -> tuple[Floats, Floats]:
        """From where to where along the line it may fly by fixes that it is so far from at their times."""
        there_m, around_m = self._along_at(time_s), _APART_SHARE * apart_m + _FLIGHT_NEAR_M
        return there_m - around_m, there_m + around_m

    def near_plan_m(self, passed_s: Floats, planned: Offsets) -> tuple[Floats, Floats]:
        """From where to where along the line it may fly by fixes for which the plan has such points."""
        there_s = np.interp(planned.progress, np.arange(1, len(passed_s) + 1), passed_s)
        there_m = self._along_at(there_s)
        return there_m - _BESIDE_PLAN_M, there_m + _BESIDE_PLAN_M

    def progress(self, passed_s: Floats, feet: _Feet) -> Floats:
        """How far the plan is flown at each of some points of the line (n,), as ``Offsets.progress``."""
        _, piece, share = feet
        ends = np.minimum(piece + 1, len(self.along_m) - 1)
        feet_m = self.along_m[piece] + share * (self.along_m[ends] - self.along_m[piece])
        rising_m = self._along_at(passed_s) + 1e-6 * np.arange(len(passed_s))
        return np.interp(feet_m, rising_m, np.arange(1, len(passed_s) + 1))

    def times_s(self, feet: _Feet) -> Floats:
        """When the vehicle is at each of some points of the line (n,)."""
        _, piece, share = feet
        ends = np.minimum(piece + 1, len(self.time_s) - 1)
        return np.asarray(self.time_s[piece] + share * (self.time_s[ends] - self.time_s[piece]))

    def _along_at(self, time_s: Floats) -> Floats:
        return np.interp(time_s, self.time_s, self.along_m)


def marks_along(flight: SimulatedDraft, axes: int) -> tuple[Floats, Floats]:
    """The points (k, 2) of a flight that are compared with the recorded line, and when it is there (k,)."""
    drawn = _DrawnFlight.of(flight, axes)
    return drawn.line_m[::_EVERY, :2], drawn.time_s[::_EVERY]


def points_along(line_m: Floats, spacing_m: float) -> tuple[Floats, Floats]:
    """Points (k, d) evenly along a line (m, d), and the index of each in the line, with its fraction."""
    along = lengths_along_m(line_m)
    marks = np.linspace(0.0, along[-1], max(2, int(along[-1] / spacing_m) + 1))
    at = np.interp(marks, along, np.arange(len(along)))
    return np.column_stack([np.interp(marks, along, column) for column in line_m.T]), at


def pieces_around(following: Indices, fixes: int) -> Indices:
    """Which pieces (k, 8) of the line through so many fixes, two or more, are near points (k,) of a path.

    ``following`` (k,) are the fixes that follow them in order.
    """
    around = following[:, None] + np.arange(-_WINDOW_FIXES - 1, _WINDOW_FIXES)
    return np.asarray(np.clip(around, 0, fixes - 2))


def _offsets_back(points_m: Floats, following: Indices, recording: LocalTrack) -> Floats:
    """Vectors (k, 2) from points to the recorded line near the fixes (k,) that follow each in order."""
    fixes = recording.north_east_m
    if len(fixes) == 1:
        return np.asarray(fixes - points_m)
    around = pieces_around(following, len(fixes))
    start, step = fixes[around], np.diff(fixes, axis=0)[around]
    share, apart = nearest_on_segments(points_m[:, None], start, step)
    nearest = apart.argmin(axis=1)
    row = np.arange(len(points_m))
    return np.asarray(start[row, nearest] + share[row, nearest, None] * step[row, nearest] - points_m)


def _matched_points(fixes_m: Floats, line_m: Floats, near_m: tuple[Floats, Floats] | None) -> _Feet:
    """Where fixes (n, d) are matched to a line (m, d), searched from where to where along it first."""
    match = match_in_order(fixes_m, line_m, _PIECE_M, quick=True, near_m=near_m)
    lengths = segment_lengths_m(line_m)
    if not len(lengths):
        return np.repeat(line_m, len(fixes_m), axis=0), match.segment, np.zeros(len(fixes_m))
    begins = lengths_along_m(line_m)
    share = (match.along_m - begins[match.segment]) / np.maximum(lengths[match.segment], 1e-9)
    share = np.clip(share, 0.0, 1.0)
    steps = line_m[match.segment + 1] - line_m[match.segment]
    return line_m[match.segment] + share[:, None] * steps, match.segment, share

"""How a draft would be flown, and how far that is from the recording: the objective of the fit.

The objective, in metres, smaller is better:

    path error, flown
    + plan share x path error, planned
    + TIME_SHARE x mean position error, flown
    + CREEPING_M_S x seconds of creeping, where the recorded speed is kept

"Flown" is what the model of ArduCopter predicts, "planned" the path on paper. A path error counts both
ways, half and half: from every fix to the path, matched in order, and from every part of the path
back to the recorded line, so that an overshoot costs what it looks like. It is the power mean of
those distances with exponent 4, so that nothing is left far off: one point at 2 m counts as much as
sixteen at 1 m. The planned part keeps the route true for vehicles that fly with other gains or in
wind. ``TIME_SHARE`` is the trade between space and time: seven metres behind the recorded vehicle
cost as much as one metre beside the track. Where the recorded speed is not asked for, only being
late counts. Where heights are as recorded, a position error is one in space, and fixes are matched in
space: the path error stays that over the ground.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.polyline import lengths_along_m, nearest_on_segments, segment_lengths_m
from flight_replay.planning.fit.basis import weights
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.reference import LocalTrack
from flight_replay.planning.fit.simulated_draft import SimulatedDraft

PLAN_SHARE, TIMED_PLAN_SHARE = 1.0, 0.3
"""Where the recorded speed is kept, the planned path has to lead the vehicle, which swings out of curves."""
TIME_SHARE = 0.15
CREEPING_M_S, CREEPING_SPEED_M_S = 0.05, 0.3
CURVE_TOLERANCE_M = 0.02
"""How well curves are drawn while fitting; the planned error of the answer is measured finer."""
_SPACING_M = 0.25
_BACK_SPACING_M = 0.5
_EVERY = round(_BACK_SPACING_M / _SPACING_M)
_PIECE_M = 1.0
_NUDGE = 0.01
_AT_STOP_M = 1.0
"""A vehicle that comes to rest shoots past its stop and comes back slowly: so near it does not creep."""
_LEAST_SCALE_M = 0.4
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
        return np.asarray(np.linalg.norm(self.off_m, axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """A draft as the model flies it, against the recording's n fixes.

    ``planned`` and ``flown`` are each the offsets of both ways: of the fixes, and of the path's own points.
    ``flown_s`` (n,) is when the vehicle flies by each fix, ``late_m`` (n,) the position error that counts.
    ``creeping_s`` is how long it creeps.
    """

    flight: SimulatedDraft
    planned: tuple[Offsets, Offsets]
    flown: tuple[Offsets, Offsets]
    flown_s: Floats
    late_m: Floats
    creeping_s: float
    plan_share: float

    @property
    def draft(self) -> Draft:
        """What was flown."""
        return self.flight.draft

    @property
    def passed_s(self) -> Floats:
        """When each place was reached, counted from the first."""
        return self.flight.passed_s

    @property
    def objective_m(self) -> float:
        """The number that the fit makes small; see the module."""
        planned, flown = path_error_m(self.planned), path_error_m(self.flown)
        late = TIME_SHARE * float(self.late_m.mean()) + CREEPING_M_S * self.creeping_s
        return flown + self.plan_share * planned + late


def path_error_m(both_ways: tuple[Offsets, Offsets]) -> float:
    """Power mean with exponent 4 of distances, both ways alike."""
    return float(np.mean([(offsets.apart_m**4).mean() for offsets in both_ways]) ** 0.25)


def scales_of(evaluation: Evaluation) -> tuple[float, float]:
    """The path errors, flown and planned, about which what legs cost is linear; not too small."""
    flown, planned = (path_error_m(both_ways) for both_ways in (evaluation.flown, evaluation.planned))
    return max(flown, _LEAST_SCALE_M), max(planned, _LEAST_SCALE_M)


def leg_costs_m(evaluation: Evaluation, scales_m: tuple[float, float], *, whole: bool) -> Floats:
    """What the errors on the leg to each place (n,) add to the objective, linear about its path errors.

    Args:
        evaluation: a draft as it is flown.
        scales_m: the path errors, flown and planned.
        whole: whether being late counts, or the path errors only.
    """
    legs = len(evaluation.draft)
    cost = np.zeros(legs)
    kinds = zip((evaluation.flown, evaluation.planned), (1.0, evaluation.plan_share), scales_m, strict=True)
    for both_ways, share, scale_m in kinds:
        for offsets in both_ways:
            total = np.bincount(offsets.leg, offsets.apart_m**4, minlength=legs)
            cost += share * total / (2 * len(offsets.leg) * 4 * scale_m**3)
    if whole:
        late_m = np.bincount(evaluation.planned[0].leg, evaluation.late_m, minlength=legs)
        cost += TIME_SHARE * late_m / len(evaluation.late_m)
    return cost


def objective_lower_bound_m(draft: Draft, recording: LocalTrack, *, timed: bool) -> float:
    """What the objective of a draft comes to at least, by its planned path alone."""
    return _plan_share(timed=timed) * path_error_m(match_to_plan(draft, recording))


def evaluate(flight: SimulatedDraft, recording: LocalTrack, *, timed: bool) -> Evaluation:
    """Compare a flight in the model with what it ought to follow.

    Args:
        flight: in the metres of the recording.
        recording: at least one fix.
        timed: whether being early counts.
    """
    planned = match_to_plan(flight.draft, recording)
    flown_s, flown = _match_to_flight(flight, recording, planned[0])
    late_m = np.asarray(np.hypot.reduce(position_offsets_m(flight, recording), axis=1))
    if not timed:
        late_m = np.where(flown_s > recording.time_s, late_m, 0.0)
    slow_s = creeping_s(flight.draft, flight.time_s, flight.place_m[:, :2]) if timed else 0.0
    return Evaluation(flight, planned, flown, flown_s, late_m, slow_s, _plan_share(timed=timed))


def creeping_s(draft: Draft, time_s: Floats, north_east_m: Floats) -> float:
    """How long a vehicle creeps that is at such places (k, 2) at such times (k,)."""
    if len(time_s) < 2:
        return 0.0
    steps_s = np.diff(time_s)
    slow = np.flatnonzero(segment_lengths_m(north_east_m) < CREEPING_SPEED_M_S * steps_s)
    if not len(slow):
        return 0.0
    stops = draft.hold_s > 0
    stops[0] = stops[-1] = True
    apart_m = np.linalg.norm(north_east_m[slow, None] - draft.places_m[stops, :2], axis=2)
    return float(steps_s[slow[apart_m.min(axis=1) > _AT_STOP_M]].sum())


def _plan_share(*, timed: bool) -> float:
    return TIMED_PLAN_SHARE if timed else PLAN_SHARE


def match_to_plan(draft: Draft, recording: LocalTrack) -> tuple[Offsets, Offsets]:
    """The offsets of the fixes from the planned path, and those of the planned path from the fixes' line."""
    path = draft.path(CURVE_TOLERANCE_M)
    line = np.column_stack([path.north_east_m, path.up_m])[:, : recording.axes]
    foot, piece, share = _matched_points(recording.places_m, line)
    counts = np.bincount(path.seq, minlength=len(draft))
    begins = np.cumsum(counts) - counts
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
    return np.asarray(direction / np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-9))


def _leg_and_part(progress: Floats, legs: int) -> tuple[Indices, Floats]:
    """Legs and parts of them from both together."""
    leg = np.clip(np.ceil(progress).astype(np.intp) - 1, 0, legs - 1)
    return leg, np.clip(progress - leg, 0.0, 1.0)


def position_offsets_m(flown: SimulatedDraft, recording: LocalTrack) -> Floats:
    """Vectors (n, axes) from every fix to where the vehicle is at that time; in the end it stays there."""
    return places_at(flown.time_s, flown.place_m[:, : recording.axes], recording.time_s) - recording.places_m


def places_at(time_s: Floats, place_m: Floats, at_s: Floats) -> Floats:
    """Places (m, d) at times (m,) of what is at places (k, d) at rising times (k,)."""
    return np.column_stack([np.interp(at_s, time_s, column) for column in place_m.T])


def _match_to_flight(
    flight: SimulatedDraft, recording: LocalTrack, planned: Offsets
) -> tuple[Floats, tuple[Offsets, Offsets]]:
    """When the vehicle flies by every fix, and the offsets of both ways.

    A point of the flight belongs to where the plan has the fixes that the vehicle flies by there.
    """
    line, times = _drawn(flight, recording.axes)
    foot, piece, share = _matched_points(recording.places_m, line)
    ends = np.minimum(piece + 1, len(times) - 1)
    flown_s = times[piece] + share * (times[ends] - times[piece])
    marks, marks_s = line[::_EVERY], times[::_EVERY]
    order = np.maximum.accumulate(flown_s)
    back = _offsets_back(marks[:, :2], np.searchsorted(order, marks_s), recording)
    progress = np.maximum.accumulate(planned.leg + planned.part)
    rising_s = order + 1e-6 * np.arange(len(order))
    where = _leg_and_part(np.interp(marks_s, rising_s, progress), len(flight.draft))
    there = Offsets(planned.leg, planned.part, recording.north_east_m - foot[:, :2])
    return flown_s, (there, Offsets(*where, back))


def marks_along(flight: SimulatedDraft, axes: int) -> tuple[Floats, Floats]:
    """The points (k, 2) of a flight that are compared with the recorded line, and when it is there (k,)."""
    line, times = _drawn(flight, axes)
    return line[::_EVERY, :2], times[::_EVERY]


def _drawn(flight: SimulatedDraft, axes: int) -> tuple[Floats, Floats]:
    """Points (k, axes) evenly along a flight, and their times (k,)."""
    line, at = points_along(flight.place_m[:, :axes], _SPACING_M)
    return line, np.interp(at, np.arange(len(flight.time_s)), flight.time_s)


def points_along(line_m: Floats, spacing_m: float) -> tuple[Floats, Floats]:
    """Points (k, d) evenly along a line (m, d), and the index of each in the line, with its fraction."""
    along = lengths_along_m(line_m)
    marks = np.linspace(0.0, along[-1], max(2, int(along[-1] / spacing_m) + 1))
    at = np.interp(marks, along, np.arange(len(along)))
    return np.column_stack([np.interp(marks, along, column) for column in line_m.T]), at


def _offsets_back(points_m: Floats, following: Indices, recording: LocalTrack) -> Floats:
    """Vectors (k, 2) from points to the recorded line near the fixes (k,) that follow each in order."""
    fixes = recording.north_east_m
    if len(fixes) == 1:
        return np.asarray(fixes - points_m)
    around = following[:, None] + np.arange(-_WINDOW_FIXES - 1, _WINDOW_FIXES)
    around = np.clip(around, 0, len(fixes) - 2)
    start, step = fixes[around], fixes[around + 1] - fixes[around]
    share, apart = nearest_on_segments(points_m[:, None], start, step)
    nearest = apart.argmin(axis=1)
    row = np.arange(len(points_m))
    return np.asarray(start[row, nearest] + share[row, nearest, None] * step[row, nearest] - points_m)


def _matched_points(fixes_m: Floats, line_m: Floats) -> tuple[Floats, Indices, Floats]:
    """Matched places (n, d) on a line (m, d), the piece of each, and how far along the piece, 0 to 1."""
    match = match_in_order(fixes_m, line_m, _PIECE_M, quick=True)
    lengths = segment_lengths_m(line_m)
    if not len(lengths):
        return np.repeat(line_m, len(fixes_m), axis=0), match.segment, np.zeros(len(fixes_m))
    begins = lengths_along_m(line_m)
    share = (match.along_m - begins[match.segment]) / np.maximum(lengths[match.segment], 1e-9)
    share = np.clip(share, 0.0, 1.0)
    steps = line_m[match.segment + 1] - line_m[match.segment]
    return line_m[match.segment] + share[:, None] * steps, match.segment, share

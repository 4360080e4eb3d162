"""How a draft would be flown, and how far that is from the recording: the objective of the fit.

The objective, in metres, smaller is better:

    path error, flown
    + PLAN_SHARE x path error, planned
    + TIME_SHARE x mean position error, flown

"Flown" is what the model of ArduCopter predicts, "planned" the path on paper, both matched in order
to all fixes. A path error is the power mean of all fixes' distances with exponent 4, so that no fix
is left far off: one at 2 m counts as much as sixteen at 1 m. The planned part keeps the route true
for vehicles that fly with other gains or in wind. ``TIME_SHARE`` is the trade between space and
time: eleven metres behind the recorded vehicle cost as much as one metre beside the track, so
corners that the vehicle can only crawl around are flown rounder. Where the recorded speed is not
asked for, only being late counts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.polyline import lengths_along_m, segment_lengths_m
from flight_replay.planning.fit.basis import weights
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.reference import LocalTrack
from flight_replay.planning.fit.simulated_draft import SimulatedDraft

PLAN_SHARE = 0.7
TIME_SHARE = 0.15
CURVE_TOLERANCE_M = 0.02
"""How well curves are drawn while fitting; the planned error of the answer is measured finer."""
_FLOWN_SPACING_M = 0.25
_PIECE_M = 1.0
_NUDGE = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """A draft as the model flies it, against the recording's n fixes.

    ``leg`` and ``part`` (n,) say where the planned path has each fix: on the way to which place, and
    how far, 0 to 1 in the curve's own parameter. ``planned_off_m`` and ``flown_off_m`` (n, 2) point
    from the path to the fix, ``direction`` (n, 2) along the planned path. ``flown_s`` (n,) is when the
    vehicle flies by, ``late_m`` (n,) the position error that counts.
    """

    flown: SimulatedDraft
    leg: NDArray[np.intp]
    part: Floats
    planned_off_m: Floats
    direction: Floats
    flown_off_m: Floats
    flown_s: Floats
    late_m: Floats

    @property
    def draft(self) -> Draft:
        """What was flown."""
        return self.flown.draft

    @property
    def passed_s(self) -> Floats:
        """When each place was reached, counted from the first."""
        return self.flown.passed_s

    @property
    def objective_m(self) -> float:
        """The number that the fit makes small; see the module."""
        flown, planned = _power_mean_m(self.flown_off_m), _power_mean_m(self.planned_off_m)
        return flown + PLAN_SHARE * planned + TIME_SHARE * float(self.late_m.mean())


def objective_lower_bound_m(draft: Draft, recording: LocalTrack) -> float:
    """What the objective of a draft comes to at least, by its planned path alone."""
    return PLAN_SHARE * _power_mean_m(match_to_plan(draft, recording)[2])


def _power_mean_m(off_m: Floats) -> float:
    """Power mean with exponent 4 of the lengths of vectors (n, 2)."""
    return float(((off_m**2).sum(axis=1) ** 2).mean() ** 0.25)


def evaluate(flown: SimulatedDraft, recording: LocalTrack, *, timed: bool) -> Evaluation:
    """Compare a flight in the model with what it ought to follow.

    Args:
        flown: in the metres of the recording.
        recording: at least one fix.
        timed: whether being early counts.
    """
    late_m = _late_m(flown, recording)
    leg, part, planned_off, direction = match_to_plan(flown.draft, recording)
    flown_s, flown_off = _match_to_flight(flown.time_s, flown.place_m[:, :2], recording)
    return Evaluation(
        flown=flown,
        leg=leg,
        part=part,
        planned_off_m=planned_off,
        direction=direction,
        flown_off_m=flown_off,
        flown_s=flown_s,
        late_m=late_m if timed else np.where(flown_s > recording.time_s, late_m, 0.0),
    )


def match_to_plan(draft: Draft, recording: LocalTrack) -> tuple[NDArray[np.intp], Floats, Floats, Floats]:
    """Where the planned path has every fix: leg, part of it, vector from there to the fix, direction."""
    path = draft.path(CURVE_TOLERANCE_M)
    foot, piece, share = _matched_points(recording.north_east_m, path.north_east_m)
    leg = path.seq[np.minimum(piece + 1, len(path.seq) - 1)]
    counts = np.bincount(path.seq, minlength=len(draft))
    begins = np.cumsum(counts) - counts
    part = np.clip((piece + 1 - begins[leg] + share) / np.maximum(counts[leg], 1), 0.0, 1.0)
    rows = weights(draft, leg, np.minimum(part + _NUDGE, 1.0)) - weights(
        draft, leg, np.maximum(part - _NUDGE, 0.0)
    )
    direction = rows @ draft.places_m[:, :2]
    direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-9)
    return leg, part, recording.north_east_m - foot, direction


def _late_m(flown: SimulatedDraft, recording: LocalTrack) -> Floats:
    """Distance (n,) of every fix from where the vehicle is at that time; it stays where its flight ended."""
    off = [
        np.interp(recording.time_s, flown.time_s, flown.place_m[:, axis]) - recording.north_east_m[:, axis]
        for axis in (0, 1)
    ]
    return np.asarray(np.hypot(*off))


def _match_to_flight(time_s: Floats, flown_m: Floats, recording: LocalTrack) -> tuple[Floats, Floats]:
    """When the vehicle flies by every fix, and the vector from there to the fix."""
    along = lengths_along_m(flown_m)
    marks = np.unique((along / _FLOWN_SPACING_M).astype(np.intp), return_index=True)[1]
    keep = np.unique(np.append(marks, len(along) - 1))
    foot, piece, share = _matched_points(recording.north_east_m, flown_m[keep])
    times = time_s[keep]
    ends = np.minimum(piece + 1, len(times) - 1)
    return times[piece] + share * (times[ends] - times[piece]), recording.north_east_m - foot


def _matched_points(fixes_m: Floats, line_m: Floats) -> tuple[Floats, NDArray[np.intp], Floats]:
    """Matched places (n, 2) on a line, the piece of each, and how far along the piece, 0 to 1."""
    match = match_in_order(fixes_m, line_m, _PIECE_M)
    lengths = segment_lengths_m(line_m)
    if not len(lengths):
        return np.repeat(line_m, len(fixes_m), axis=0), match.segment, np.zeros(len(fixes_m))
    begins = lengths_along_m(line_m)
    share = (match.along_m - begins[match.segment]) / np.maximum(lengths[match.segment], 1e-9)
    share = np.clip(share, 0.0, 1.0)
    steps = line_m[match.segment + 1] - line_m[match.segment]
    return line_m[match.segment] + share[:, None] * steps, match.segment, share

"""How the flight of a draft changes with its speeds, places and waits, each changed a little.

A change is flown in the model over the legs that it shapes. All that comes after is flown as before, sooner
or later. What it does to the planned path needs no flight: that is a sum of places. Nor does a longer wait.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.planning.fit.basis import weights
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.lateness import places_at, velocities_at_m_s
from flight_replay.planning.fit.legs.flight_points import (
    FlightPoints,
    marks_of_flight,
    points_at_fixes,
    points_beside_fixes,
)
from flight_replay.planning.fit.legs.local_flights import LocalFlight, LocalFlights
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.offsets import Offsets, directions
from flight_replay.planning.fit.problem import FitProblem

SPEED, NORTH, EAST, HOLD = range(4)
"""What may change of a place: the logarithm of the speed on the way to it, how far north and east it is, and
how many seconds are waited at it."""
_SPEED_CHANGE, _PLACE_CHANGE_M = 0.08, 0.4
_LEGS_AFTER_SPEED, _LEGS_BEFORE_PLACE, _LEGS_AFTER_PLACE = 1, 1, 2
_FOLLOWS_S = 0.9
"""For so long the vehicle flies otherwise after its target has left the last leg that a change shapes."""


@dataclass(frozen=True, slots=True, eq=False)
class ErrorVectors:
    """What a flight is off by, as vectors: n fixes at equal times and beside the flown and planned paths.

    ``position`` (n, 2), ``flown`` (n, 2) and ``planned`` (n, 2) are those; ``flown_back`` (m, 2) and
    ``planned_back`` (k, 2) are points of the paths beside the recorded line; see ``planned_marks``.
    """

    position: Floats
    flown: Floats
    planned: Floats
    flown_back: Floats
    planned_back: Floats

    @property
    def stacked(self) -> Floats:
        """All components (6 n + 2 m + 2 k,)."""
        kinds = self.position, self.flown, self.planned, self.flown_back, self.planned_back
        return np.concatenate([each.ravel() for each in kinds])

    def moved_back(self, moves: Floats) -> tuple[Floats, Floats]:
        """Those of the paths' points after moves of the stacked components."""
        before = np.concatenate([self.flown_back, self.planned_back])
        after = before + moves[-before.size :].reshape(-1, 2)
        return after[: len(self.flown_back)], after[len(self.flown_back) :]


@dataclass(frozen=True, slots=True, eq=False)
class FlightDerivatives:
    """By the p ``changes_of`` a draft of n places.

    ``at_fixes`` (2 k, p) are those of the errors at equal times, ``beside`` (m, p) those of the rest of the
    stacked ``ErrorVectors``, ``passed_s`` (n, p) those of when places are left. ``steps`` is how many steps
    of the model it took.
    """

    at_fixes: Floats
    beside: Floats
    passed_s: Floats
    steps: int

    def errors_by(self, changes: Floats) -> Floats:
        """What changes (p,) make of the stacked errors."""
        return np.concatenate([self.at_fixes @ changes, self.beside @ changes])


def changes_of(draft: Draft, *, timed: bool) -> tuple[Indices, Indices]:
    """What may change of a draft (p,), and of which place (p,): of all but the first.

    At the vehicle's own speed no speeds and waits are to be found, and the last place stays where the
    recording ends.
    """
    kinds, last = ([SPEED, NORTH, EAST], len(draft) - 1) if timed else ([NORTH, EAST], len(draft) - 2)
    places = np.arange(1, last + 1)
    waits = 1 + np.flatnonzero(timed & (draft.hold_s[1:-1] > 0))
    changed = np.concatenate([np.tile(np.array(kinds, np.intp), len(places)), np.full(len(waits), HOLD)])
    return changed, np.concatenate([np.repeat(places, len(kinds)), waits])


def flight_derivatives(
    problem: FitProblem, base: Evaluation, longest_s: float, size: float = 1.0
) -> FlightDerivatives:
    """The derivatives of a draft's flight.

    Args:
        problem: the recording, at least two fixes, and the vehicle.
        base: the draft as it is flown, at least two places.
        longest_s: what takes longer is taken not to change anything.
        size: how large changes are, as a share of the usual ones; below 0 to the other side.
    """
    legs = _ChangedLegs(problem, base, longest_s, size)
    kinds, places = changes_of(base.draft, timed=problem.timed)
    marks, flown_count, count = planned_marks(base), legs.errors_count, len(problem.recording)
    errors = np.zeros((len(kinds), flown_count + len(marks.leg), 2))
    passed_s = np.zeros((len(kinds), len(base.draft)))
    for row, each in enumerate(zip(kinds.tolist(), places.tolist(), strict=True)):
        legs.add(*each, errors[row], passed_s[row])
    errors[:, 2 * count : 3 * count] = _of_planned(base, base.planned[0])
    errors[:, flown_count:] = _of_planned(base, marks)
    at_fixes, beside = np.split(errors.reshape(len(kinds), -1).T, [2 * count])
    return FlightDerivatives(at_fixes, beside, passed_s.T, legs.steps)


def planned_marks(evaluation: Evaluation) -> Offsets:
    """The planned path's own points that count in steps: none where the recorded speed is kept.

    The plan counts little there, and steps are as good without them.
    """
    planned = evaluation.planned[1]
    count = 0 if evaluation.timed else len(planned.leg)
    return Offsets(planned.leg[:count], planned.part[:count], planned.off_m[:count])


def _of_planned(base: Evaluation, offsets: Offsets) -> Floats:
    """The derivatives (p, m, 2) of the errors of m points of the planned path, or beside it."""
    kinds, places = changes_of(base.draft, timed=base.timed)
    moves = weights(base.draft, offsets.leg, offsets.part)[:, places].T
    along = directions(base.draft, offsets)
    found = np.zeros((*moves.shape, 2))
    for axis, kind in enumerate((NORTH, EAST)):
        across = np.eye(2)[axis] - along * along[:, axis, None]
        found[kinds == kind] = -moves[kinds == kind, :, None] * across
    return found


class _ChangedLegs:
    """A draft's flight, and what changes of it do to the errors of its points."""

    def __init__(self, problem: FitProblem, base: Evaluation, longest_s: float, size: float) -> None:
        self._speed_change, self._place_change_m = size * _SPEED_CHANGE, size * _PLACE_CHANGE_M
        self._flights = LocalFlights(problem, base.draft, longest_s)
        self._last = len(base.draft) - 1
        whole = self._flights.fly(self._flights.draft, 1, self._last)
        self._passed_s = np.append(self._flights.left_s(0), whole.passed_s)
        count = len(problem.recording)
        self._at_fixes = points_at_fixes(problem, whole)
        self._velocity_m_s = velocities_at_m_s(whole.time_s, whole.north_east_m, self._at_fixes.time_s)
        self._beside_fixes = points_beside_fixes(base, whole, count)
        self._marks = marks_of_flight(problem, base, whole, 3 * count)

    @property
    def errors_count(self) -> int:
        """How many vectors the stacked errors have, but for the planned path's own points."""
        return self._marks.row + len(self._marks.time_s)

    @property
    def steps(self) -> int:
        """Steps of the model so far."""
        return self._flights.steps

    def add(self, kind: int, place: int, errors: Floats, passed_s: Floats) -> None:
        """Note the derivatives of errors (m, 2) and of when places are left (n,); none if it cannot be."""
        if kind == HOLD:
            self._add_wait(place, errors, passed_s)
            return
        changed, first, last, size = self._changed(kind, place)
        first, last = max(first, 1), min(last, self._last)
        try:
            flown = self._flights.fly(changed, first, last)
        except MissionError:
            return
        passed_s[first : last + 1] = (flown.passed_s - self._passed_s[first : last + 1]) / size
        passed_s[last + 1 :] = passed_s[last]
        self._add_errors(errors, flown, first, last, size)

    def _add_wait(self, place: int, errors: Floats, passed_s: Floats) -> None:
        """A second more at a place makes all that comes after it a second later, and changes no path."""
        passed_s[place:] = 1.0
        fixes = self._at_fixes
        first = int(np.searchsorted(fixes.time_s, self._passed_s[place]))
        errors[first : len(fixes.time_s)] = -self._velocity_m_s[first:]

    def _changed(self, kind: int, place: int) -> tuple[Draft, int, int, float]:
        """The draft with a change, the first and last of the legs that it shapes, and how large it is."""
        draft = self._flights.draft
        if kind == SPEED:
            speeds, size = draft.speed_m_s.copy(), self._speed_change
            speeds[place] *= np.exp(size)
            return replace(draft, speed_m_s=speeds), place, place + _LEGS_AFTER_SPEED, size
        places, size = draft.places_m.copy(), self._place_change_m
        places[place, kind - NORTH] += size
        changed = replace(draft, places_m=places)
        return changed, place - _LEGS_BEFORE_PLACE, place + _LEGS_AFTER_PLACE, size

    def _add_errors(self, errors: Floats, flown: LocalFlight, first: int, last: int, size: float) -> None:
        fixes, begin_s = self._at_fixes, float(self._passed_s[first - 1])
        some = fixes.between(begin_s, flown.left_s)
        errors[some] = _moves_m(flown, fixes, some, fixes.time_s[some]) / size
        later = float(flown.passed_s[-1] - self._passed_s[last]) / size
        errors[some.stop : len(fixes.time_s)] = -later * self._velocity_m_s[some.stop :]
        usual_s = np.append(self._passed_s[first - 1 : last + 1], self._passed_s[last] + _FOLLOWS_S)
        now_s = np.concatenate([[begin_s], flown.passed_s, [flown.passed_s[-1] + _FOLLOWS_S]])
        for points in (self._beside_fixes, self._marks):
            some = points.between(begin_s, float(usual_s[-1]))
            at_s = np.interp(points.time_s[some], usual_s, now_s)
            across_m = points.across(_moves_m(flown, points, some, at_s), some)
            errors[points.row + some.start : points.row + some.stop] = -across_m / size


def _moves_m(flown: LocalFlight, points: FlightPoints, some: slice, at_s: Floats) -> Floats:
    """How far some points (k, 2) move that are passed at such times (k,) now."""
    return places_at(flown.time_s, flown.north_east_m, at_s) - points.place_m[some]

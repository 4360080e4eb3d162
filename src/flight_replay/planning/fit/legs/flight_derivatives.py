"""How the flight of a draft changes with its speeds and places, each changed a little in the model.

A change is flown over the legs that it shapes. All that comes after is flown as before, sooner or later.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.polyline import nearest_on_line_m
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.legs.local_flights import LocalFlight, LocalFlights
from flight_replay.planning.fit.objective import Evaluation, places_at
from flight_replay.planning.fit.offsets import CURVE_TOLERANCE_M, marks_along
from flight_replay.planning.fit.problem import FitProblem

CHANGES_A_PLACE = 3
"""The logarithm of the speed on the way to it, and how far north and east it is."""
_SPEED_CHANGE, _PLACE_CHANGE_M = 0.08, 0.4
_LEGS_AFTER_SPEED, _LEGS_BEFORE_PLACE, _LEGS_AFTER_PLACE = 1, 1, 2
_BEFORE_S = 1.0
_AROUND_FIXES = 3
_EVERY = 3
"""Lines through every third step of a flight are within millimetres of it."""


@dataclass(frozen=True, slots=True, eq=False)
class ErrorVectors:
    """What a flight is off by, as vectors: n fixes at equal times and beside the flown and planned paths.

    ``position`` (n, 2), ``there`` (n, 2) and ``planned`` (n, 2) are those; ``back`` (m, 2) are m points
    of the flown path beside the recorded line.
    """

    position: Floats
    there: Floats
    planned: Floats
    back: Floats

    @property
    def stacked(self) -> Floats:
        """All components (6 n + 2 m,)."""
        return np.concatenate([each.ravel() for each in (self.position, self.there, self.planned, self.back)])


@dataclass(frozen=True, slots=True, eq=False)
class FlightDerivatives:
    """By the p = 3 (n - 1) changes of n places, ``CHANGES_A_PLACE`` of each place but the first.

    ``errors`` (m, p) are those of the stacked ``ErrorVectors``, ``passed_s`` (n, p) those of when places
    are left. ``steps`` is how many steps of the model it took.
    """

    errors: Floats
    passed_s: Floats
    steps: int

    def mean_with(self, other: FlightDerivatives) -> FlightDerivatives:
        """The mean of these derivatives and others of the same flight."""
        errors = self.errors + other.errors
        errors *= 0.5  # In place: these are what takes most memory.
        passed_s = 0.5 * (self.passed_s + other.passed_s)
        return FlightDerivatives(errors, passed_s, self.steps + other.steps)


def flight_derivatives(
    problem: FitProblem, base: Evaluation, longest_s: float, size: float = 1.0
) -> FlightDerivatives:
    """The derivatives of a draft's flight.

    Args:
        problem: the recording and the vehicle.
        base: the draft as it is flown, at least two places.
        longest_s: what takes longer is taken not to change anything.
        size: how large changes are, as a share of the usual ones; below 0 to the other side.
    """
    legs = _ChangedLegs(problem, base, longest_s, size)
    places = len(base.draft)
    changes = [(change, place) for place in range(1, places) for change in range(CHANGES_A_PLACE)]
    errors, passed_s = np.empty((len(changes), legs.errors_count)), np.empty((len(changes), places))
    for row, each in enumerate(changes):
        errors[row], passed_s[row] = legs.by(*each)
    return FlightDerivatives(errors.T, passed_s.T, legs.steps)


@dataclass(frozen=True, slots=True, eq=False)
class _UsualLegs:
    """Some legs as they are flown and planned without a change, and the fixes and marks beside them.

    ``before_m`` (k, 2) is what was flown in the second before ``begin_s``. ``feet_m`` and
    ``planned_feet_m`` (n, 2) are the nearest points to the n fixes that are passed on the legs. ``marks``
    (m,) are those on them, ``mark_shares`` (m,) how far in time, ``marks_off_m`` (m, 2) their offsets
    from ``near_m`` (j, 2), the recorded line.
    """

    begin_s: float
    before_m: Floats
    feet_m: Floats
    marks: Indices
    mark_shares: Floats
    marks_off_m: Floats
    near_m: Floats
    planned_feet_m: Floats


class _ChangedLegs:
    """A draft's flight, and what changes of it do to the errors."""

    def __init__(self, problem: FitProblem, base: Evaluation, longest_s: float, size: float) -> None:
        self._speed_change, self._place_change_m = size * _SPEED_CHANGE, size * _PLACE_CHANGE_M
        self._recording = problem.recording
        self._flights = LocalFlights(problem, base.draft, longest_s)
        self._last = len(base.draft) - 1
        self._whole = self._flights.fly(self._flights.draft, 1, self._last)
        self._passed_s = np.append(self._flights.left_s(0), self._whole.passed_s)
        self._passing_leg = np.maximum.accumulate(base.planned[0].leg)
        self._marks_m, self._marks_s = marks_along(base.flight, problem.recording.axes)
        self._latest: tuple[tuple[int, int], _UsualLegs] | None = None

    @property
    def errors_count(self) -> int:
        """How many components the stacked errors have."""
        return 2 * (3 * len(self._recording) + len(self._marks_m))

    @property
    def steps(self) -> int:
        """Steps of the model so far."""
        return self._flights.steps

    def by(self, change: int, place: int) -> tuple[Floats, Floats]:
        """The derivatives of the stacked errors (m,) and of when places are left (n,); 0 if it cannot be."""
        draft = self._flights.draft
        if change == 0:
            speeds, size = draft.speed_m_s.copy(), self._speed_change
            speeds[place] *= np.exp(size)
            changed = replace(draft, speed_m_s=speeds)
            first, last = place, place + _LEGS_AFTER_SPEED
        else:
            places, size = draft.places_m.copy(), self._place_change_m
            places[place, change - 1] += size
            changed = replace(draft, places_m=places)
            first, last = place - _LEGS_BEFORE_PLACE, place + _LEGS_AFTER_PLACE
        errors, passed_s = self._differences(changed, max(first, 1), min(last, self._last))
        return errors / size, passed_s / size

    def _differences(self, changed: Draft, first: int, last: int) -> tuple[Floats, Floats]:
        passed_s = np.zeros(self._last + 1)
        fixes = np.zeros_like(self._recording.north_east_m)
        errors = ErrorVectors(fixes, fixes.copy(), fixes.copy(), np.zeros_like(self._marks_m))
        try:
            flown = self._flights.fly(changed, first, last)
        except MissionError:
            return errors.stacked, passed_s
        passed_s[first : last + 1] = flown.passed_s - self._passed_s[first : last + 1]
        passed_s[last + 1 :] = passed_s[last]
        begin, end = np.searchsorted(self._passing_leg, [first, last + 1])
        self._add_position(errors.position, flown, first, float(passed_s[last]))
        self._add_path(errors, flown, first, last, slice(int(begin), int(end)))
        if not np.array_equal(changed.places_m, self._flights.draft.places_m):
            self._add_planned(errors.planned, changed, first, last, slice(int(begin), int(end)))
        return errors.stacked, passed_s

    def _add_position(self, position_m: Floats, flown: LocalFlight, first: int, later_s: float) -> None:
        after = np.flatnonzero(self._recording.time_s > self._passed_s[first - 1])
        times_s = self._recording.time_s[after]
        there = places_at(flown.time_s, flown.north_east_m, times_s)
        whole = self._whole
        as_before = places_at(whole.time_s, whole.north_east_m, times_s - later_s)
        there = np.where((times_s <= flown.left_s)[:, None], there, as_before)
        position_m[after] = there - places_at(whole.time_s, whole.north_east_m, times_s)

    def _add_path(self, errors: ErrorVectors, flown: LocalFlight, first: int, last: int, some: slice) -> None:
        usual = self._usual(first, last)
        fixes = self._recording.north_east_m
        line = np.vstack([usual.before_m, flown.north_east_m[::_EVERY]])
        errors.there[some] = usual.feet_m - _feet_m(fixes[some], line)
        marks_s = usual.begin_s + usual.mark_shares * (float(flown.passed_s[-1]) - usual.begin_s)
        marks = places_at(flown.time_s, flown.north_east_m, marks_s)
        errors.back[usual.marks] = _feet_m(marks, usual.near_m) - marks - usual.marks_off_m

    def _add_planned(self, planned_m: Floats, changed: Draft, first: int, last: int, some: slice) -> None:
        fixes = self._recording.north_east_m[some]
        moved = changed.legs_path(first - 1, last, CURVE_TOLERANCE_M)
        planned_m[some] = self._usual(first, last).planned_feet_m - _feet_m(fixes, moved)

    def _usual(self, first: int, last: int) -> _UsualLegs:
        """What several changes of the same legs are compared with."""
        if self._latest is None or self._latest[0] != (first, last):
            self._latest = (first, last), self._usual_legs(first, last)
        return self._latest[1]

    def _usual_legs(self, first: int, last: int) -> _UsualLegs:
        begin, end = np.searchsorted(self._passing_leg, [first, last + 1]).tolist()
        begin_s, end_s = float(self._passed_s[first - 1]), float(self._passed_s[last])
        time_s, north_east_m = self._whole.time_s, self._whole.north_east_m
        from_row, begin_row, end_row = np.searchsorted(
            time_s, [begin_s - _BEFORE_S, begin_s, end_s + _BEFORE_S]
        ).tolist()
        before = north_east_m[from_row:begin_row:_EVERY]
        line = np.vstack([before, north_east_m[begin_row : end_row + 1 : _EVERY]])
        fixes = self._recording.north_east_m
        marks = np.flatnonzero((self._marks_s >= begin_s) & (self._marks_s <= end_s))
        near = fixes[max(0, begin - _AROUND_FIXES) : end + _AROUND_FIXES]
        return _UsualLegs(
            begin_s=begin_s,
            before_m=before,
            feet_m=_feet_m(fixes[begin:end], line),
            marks=marks,
            mark_shares=(self._marks_s[marks] - begin_s) / max(end_s - begin_s, 1e-6),
            marks_off_m=_feet_m(self._marks_m[marks], near) - self._marks_m[marks],
            near_m=near,
            planned_feet_m=_feet_m(
                fixes[begin:end], self._flights.draft.legs_path(first - 1, last, CURVE_TOLERANCE_M)
            ),
        )


def _feet_m(points_m: Floats, line_m: Floats) -> Floats:
    """The points (m, 2) of a line (k, 2) that are nearest to points (m, 2); these themselves without one."""
    return nearest_on_line_m(points_m, line_m) if len(line_m) > 1 and len(points_m) else points_m

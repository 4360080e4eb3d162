"""What a few legs of a draft add to the objective, linear about the errors that the draft has as a whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.matching import distances_in_order_m
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.legs.local_flights import LocalFlight
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.offsets import CURVE_TOLERANCE_M, Offsets, points_along
from flight_replay.planning.fit.reference import LocalTrack

_SPACING_M = 1.0
_AROUND_FIXES = 3
_LEAST_SCALE_M = 0.3


@dataclass(frozen=True, slots=True)
class _Derivatives:
    """Those of the objective by the fourth power of the distance of a fix, and of one of a path's points."""

    by_fix: float
    by_point: float

    @classmethod
    def of(cls, both_ways: tuple[Offsets, Offsets], share: float, path_error_m: float) -> _Derivatives:
        """By those of some offsets, of a path error that counts ``share``."""
        by_mean = share / (8 * max(path_error_m, _LEAST_SCALE_M) ** 3)
        fixes, points = both_ways
        return cls(by_mean / len(fixes.leg), by_mean / len(points.leg))


@dataclass(frozen=True, slots=True, eq=False)
class LocalCost:
    """The objective of some legs of drafts like the one that was evaluated."""

    recording: LocalTrack
    passing_leg: Floats
    """The leg (n,) on which the draft passes each fix."""
    by_planned: _Derivatives
    by_flown: _Derivatives

    @classmethod
    def of(cls, evaluation: Evaluation, recording: LocalTrack) -> LocalCost:
        """About a draft as it is flown."""
        passing_leg = np.maximum.accumulate(evaluation.planned[0].leg)
        by_flown, by_planned = (
            _Derivatives.of(both_ways, share, error_m)
            for both_ways, share, error_m in zip(
                (evaluation.flown, evaluation.planned),
                evaluation.path_shares,
                evaluation.path_errors_m,
                strict=True,
            )
        )
        return cls(recording, passing_leg, by_planned, by_flown)

    def fixes_m(self, first: int, last: int) -> Floats:
        """The fixes (n, 2) that the draft passes on the legs to places ``first`` to ``last``."""
        begin, end = np.searchsorted(self.passing_leg, [first, last + 1])
        return self.recording.north_east_m[begin:end]

    def of_legs(self, draft: Draft, flight: LocalFlight, first: int, last: int) -> float:
        """What the legs to places ``first`` to ``last`` cost in metres of the objective.

        Args:
            draft: as long as the one that was evaluated.
            flight: the legs as they are flown.
            first: the first of the places.
            last: the last of the places.
        """
        begin, end = np.searchsorted(self.passing_leg, [first, last + 1])
        planned = draft.legs_path(first, last, CURVE_TOLERANCE_M)
        cost = self._path_m(planned, planned, begin, end, self.by_planned)
        on_legs_m = flight.north_east_m[: flight.ended]
        return cost + self._path_m(flight.north_east_m, on_legs_m, begin, end, self.by_flown)

    def _path_m(
        self, line_m: Floats, on_legs_m: Floats, begin: int, end: int, derivatives: _Derivatives
    ) -> float:
        """What a line, and the part of it that is on the legs, add to the objective, both ways."""
        fixes = self.recording.north_east_m
        there = distances_in_order_m(fixes[begin:end], points_along(line_m, _SPACING_M)[0])
        near = fixes[max(0, begin - _AROUND_FIXES) : end + _AROUND_FIXES]
        back = distances_in_order_m(points_along(on_legs_m, _SPACING_M)[0], near)
        return float((there**4).sum() * derivatives.by_fix + (back**4).sum() * derivatives.by_point)

"""What is off in a draft's flight, linear about it in changes of speeds, places and waits, and its least.

The errors' squares are weighted so that their slope is that of the objective.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.lateness import lateness_slope
from flight_replay.planning.fit.legs.flight_derivatives import ErrorVectors, FlightDerivatives
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.solvers.nonnegative import smallest_nonnegative
from flight_replay.planning.fit.solvers.normal_equations import normal_equations

_MOST_TIMES = 2
_DECIMALS = 5
"""Changes are kept to so many: what last bits leave of none would be blamed for delays like any other."""
_NEAR_M, _LEAST_PATH_ERROR_M, _LEAST_SQUARE_M2 = 0.5, 0.1, 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Sides:
    """Derivatives by changes above 0, and by those below 0; without these the first stand for both."""

    one: FlightDerivatives
    other: FlightDerivatives | None = None

    def errors(self, changes: Floats) -> Floats:
        """What the stacked errors (m,) change by."""
        if self.other is None:
            return self.one.errors_by(changes)
        return self.one.errors_by(np.maximum(changes, 0)) + self.other.errors_by(np.minimum(changes, 0))

    def passed_s(self, changes: Floats) -> Floats:
        """How much later places (n,) are left."""
        if self.other is None:
            return self.one.passed_s @ changes
        return self.one.passed_s @ np.maximum(changes, 0) + self.other.passed_s @ np.minimum(changes, 0)


@dataclass(frozen=True, slots=True, eq=False)
class LinearModel:
    """How the weighted squares of errors go with p changes: their normal matrix, and their force.

    Changes to both sides are 2 p numbers that are not negative: how far to one side, and to the other.
    """

    normal: Floats
    force: Floats
    both_sides: bool

    @classmethod
    def of(cls, sides: Sides, errors: ErrorVectors, evaluation: Evaluation) -> LinearModel:
        """That by the derivatives of the stacked errors (m,)."""
        groups = [sides.one] if sides.other is None else [sides.one, sides.other]
        columns = [(each.at_fixes.T, each.beside.T) for each in groups]
        normal, force = normal_equations(columns, _weights(errors, evaluation), errors.stacked)
        if sides.other is not None:
            count = len(force) // 2
            normal[:count, count:] *= -1
            normal[count:, :count] *= -1
            force[count:] *= -1
        return cls(normal, force, sides.other is not None)

    def best_changes(self, damping: float, usual: Floats) -> Floats:
        """The changes (p,) that make them small, none too large against the usual ones (p,)."""
        most = _MOST_TIMES * usual
        sizes = np.tile(usual, 2) if self.both_sides else usual
        damped = self.normal + np.diag(damping / sizes**2)
        if self.both_sides:
            both = np.minimum(smallest_nonnegative(damped, -self.force), np.tile(most, 2))
            changes = np.subtract(*np.split(both, 2))
        else:
            changes = np.clip(np.linalg.solve(damped, -self.force), -most, most)
        return np.asarray(changes.round(_DECIMALS))


def _weights(errors: ErrorVectors, evaluation: Evaluation) -> Floats:
    """What the squares of the errors' components (m,) count, so that their slope is the objective's."""
    late_m = evaluation.late_m
    slope = lateness_slope(late_m) * (late_m > 0)
    late = evaluation.time_share * slope / (len(late_m) * np.maximum(late_m, _NEAR_M))
    flown_m, planned_m = (max(each, _LEAST_PATH_ERROR_M) for each in evaluation.path_errors_m)
    flown_share, planned_share = evaluation.path_shares
    flown, flown_back = (
        flown_share * _path_weights(each, flown_m) for each in (errors.flown, errors.flown_back)
    )
    planned, planned_back = (
        planned_share * _path_weights(each, planned_m) for each in (errors.planned, errors.planned_back)
    )
    return np.repeat(np.concatenate([late, flown, planned, flown_back, planned_back]), 2)


def _path_weights(off_m: Floats, scale_m: float) -> Floats:
    """The same for vectors (k, 2) of one way of a path error, which is ``scale_m``."""
    squares = (off_m**2).sum(axis=1)
    return np.asarray((squares + _LEAST_SQUARE_M2) / (2 * max(len(off_m), 1) * scale_m**3))

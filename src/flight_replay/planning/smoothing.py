"""The smooth motion nearest to places at given times, within bounds of its derivatives.

The motion is a cubic spline with equal knots: its acceleration is linear between knots and its jerk
constant in each span, so that bounds at the knots and in the spans hold everywhere. Its coefficients
solve a second-order cone programme, which is convex: there is one best motion, and Clarabel finds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import clarabel
import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats

_DEGREE = 3
_DIFFERENCES = {1: (-0.5, 0.0, 0.5), 2: (1.0, -2.0, 1.0), 3: (-1.0, 3.0, -3.0, 1.0)}
"""Derivatives of a cubic spline from neighbouring coefficients: at the knots, of order 3 in the spans."""
_SOLVED = (clarabel.SolverStatus.Solved, clarabel.SolverStatus.AlmostSolved)


@dataclass(frozen=True, slots=True)
class Knots:
    """The knots of a cubic spline: ``spans`` equal spans of ``step_s`` from ``begin_s`` on."""

    begin_s: float
    step_s: float
    spans: int

    @classmethod
    def between(cls, begin_s: float, end_s: float, step_s: float) -> Knots:
        """Knots from ``begin_s`` until ``end_s`` or a little later."""
        return cls(begin_s, step_s, max(int(np.ceil((end_s - begin_s) / step_s - 1e-9)), 1))

    @property
    def end_s(self) -> float:
        """Where the last span ends."""
        return self.begin_s + self.spans * self.step_s

    @property
    def size(self) -> int:
        """Number of coefficients of a spline."""
        return self.spans + _DEGREE

    @property
    def times_s(self) -> Floats:
        """Where spans begin and end (spans + 1,)."""
        return np.asarray(self.begin_s + self.step_s * np.arange(self.spans + 1))

    def spline(self, coefficients: Floats) -> BSpline:
        """The spline with coefficients (size, axes)."""
        return BSpline(self._extended_s, coefficients, _DEGREE)

    def values(self, times_s: Floats) -> Any:
        """The sparse matrix (n, size) that gives values at times (n,) from coefficients."""
        inside = np.clip(times_s, self.begin_s, self.end_s)
        return BSpline.design_matrix(inside, self._extended_s, _DEGREE)

    def derivative(self, order: int) -> Any:
        """The sparse matrix (m, size) of a derivative: 1 and 2 at the knots, 3 in the spans."""
        weights = [weight / self.step_s**order for weight in _DIFFERENCES[order]]
        shape = (self.spans + (order < _DEGREE), self.size)
        return sparse.diags_array(weights, offsets=range(len(weights)), shape=shape, format="csr")

    @property
    def _extended_s(self) -> Floats:
        return np.asarray(self.begin_s + self.step_s * np.arange(-_DEGREE, self.spans + _DEGREE + 1))


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Where the motion should be: times (n,), places (n, axes), and how much each counts (n,)."""

    time_s: Floats
    place: Floats
    weight: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Bound:
    """At every knot or span, the vector ``rows @ coefficients + offset`` is at most ``most`` long.

    ``rows`` is one sparse matrix (m, size * axes) for each component of the vector; the coefficients are
    those of the first axis, then those of the next. ``offset`` is (m, components).
    """

    rows: Sequence[Any]
    most: float
    offset: Floats | float = 0.0


def length_bound(knots: Knots, order: int, axes: int, most: float) -> Bound:
    """A derivative's length, over all axes, is at most ``most``."""
    rates = knots.derivative(order)
    unit = sparse.eye_array(axes, format="csr")
    return Bound([sparse.kron(unit[[axis]], rates) for axis in range(axes)], most)


def nearest_motion(
    knots: Knots,
    samples: Samples,
    bounds: Sequence[Bound],
    smoothness_s6: float,
    least: float = -np.inf,
) -> Floats:
    """Coefficients (size, axes) of the motion nearest to ``samples`` that is at rest at both ends.

    Args:
        knots: of the spline.
        samples: what it should pass: the sum of weighted squared distances is made small.
        bounds: what holds everywhere.
        smoothness_s6: weight of squared jerk, integrated over time, beside squared distances.
        least: what no component is ever below; a spline stays within its coefficients.

    Raises:
        MissionError: there is no such motion.
    """
    axes = samples.place.shape[1]
    middle = np.average(samples.place, axis=0, weights=samples.weight)
    # Around zero: a solver's tolerance grows with the numbers, and bounds are those of derivatives.
    samples = replace(samples, place=samples.place - middle)
    blocks = [_at_rest(knots, axes), *(_cones(bound) for bound in bounds)]
    if np.isfinite(least):
        blocks.append(_at_least(knots.size, least - middle))
    square, linear = _cost(knots, samples, smoothness_s6)
    found = _solved(sparse.kron(sparse.eye_array(axes), square), linear.T.ravel(), blocks)
    return np.asarray(np.reshape(found, (axes, knots.size)).T + middle)


def _solved(square: Any, linear: Floats, blocks: Sequence[tuple[Any, Floats, list[Any]]]) -> Floats:
    """What makes the cost small, within all cones of ``blocks``: rows, constants and cones."""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix(sparse.triu(square)),
        linear,
        sparse.csc_matrix(sparse.vstack([rows for rows, _, _ in blocks])),
        np.concatenate([constants for _, constants, _ in blocks]),
        [cone for _, _, cones in blocks for cone in cones],
        settings,
    ).solve()
    if solution.status not in _SOLVED:
        raise MissionError(
            f"No smooth motion follows the recording ({solution.status}); choose a part of it."
        )
    return np.asarray(solution.x)


def _cost(knots: Knots, samples: Samples, smoothness_s6: float) -> tuple[Any, Floats]:
    """Square part (size, size) and linear part (size, axes) of distances and jerk."""
    values, jerk = knots.values(samples.time_s), knots.derivative(3)
    weighted = values.T @ sparse.diags_array(samples.weight)
    square = weighted @ values + smoothness_s6 * knots.step_s * (jerk.T @ jerk)
    return square, -np.asarray(weighted @ samples.place)


def _at_rest(knots: Knots, axes: int) -> tuple[Any, Floats, list[Any]]:
    """Velocity and acceleration are zero at both ends."""
    ends = sparse.vstack([knots.derivative(order)[[0, -1]] for order in (1, 2)])
    rows = sparse.kron(sparse.eye_array(axes), ends)
    return rows, np.zeros(rows.shape[0]), [clarabel.ZeroConeT(rows.shape[0])]


def _at_least(size: int, least: Floats) -> tuple[Any, Floats, list[Any]]:
    """Every one of the ``size`` coefficients of each axis is at least the axis' ``least`` (axes,)."""
    count = size * len(least)
    return -sparse.eye_array(count), -np.repeat(least, size), [clarabel.NonnegativeConeT(count)]


def _cones(bound: Bound) -> tuple[Any, Floats, list[Any]]:
    """A second-order cone a row: how long the vector may be, then its components."""
    count, width = bound.rows[0].shape[0], len(bound.rows) + 1
    constants = np.empty((count, width))
    constants[:, 0], constants[:, 1:] = bound.most, bound.offset
    empty = sparse.csr_array(bound.rows[0].shape)
    by_component = sparse.vstack([empty, *(-rows for rows in bound.rows)], format="csr")
    by_cone = np.arange(width * count).reshape(width, count).T.ravel()
    return by_component[by_cone], constants.ravel(), [clarabel.SecondOrderConeT(width)] * count

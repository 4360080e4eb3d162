"""Moving the places of a draft so that its path comes nearer to the recording: one Gauss-Newton step."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.planning.fit.basis import shares, weights
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.objective import path_error_m
from flight_replay.planning.fit.offsets import Offsets, directions
from flight_replay.planning.fit.solvers.banded import solve_banded

ALONG_SHARE = 0.05
"""How much a place resists sliding along the path, against moving across it."""
_STILL = 0.01
_LONGEST_STEP_M = 3.0
_BAND = 7
"""Norths and easts of places that shape a leg together, or a third difference: those of four in a row."""
_LEAST_WEIGHT, _MOST_WEIGHT = 0.5, 5.0


@dataclass(frozen=True, slots=True, eq=False)
class Residuals:
    """Vectors ``off_m`` (m, 2) from m points of the path, ``part`` of the way along ``leg``, to the fixes.

    ``direction`` (m, 2) are unit vectors along the path there, ``weight`` (m,) how much each counts.
    """

    leg: Indices
    part: Floats
    direction: Floats
    off_m: Floats
    weight: Floats


def weighted_residuals(
    draft: Draft, both_ways: tuple[Offsets, Offsets], total: float, power: float = 1.0
) -> list[Residuals]:
    """What to make small so that a path comes nearer to the recording, both ways.

    Args:
        draft: whose path it is.
        both_ways: offsets of the fixes from the path, and of the path from the recorded line.
        total: what all points together count, half of it each way.
        power: far points count more, by this power of their distance.
    """
    usual_m = max(path_error_m(both_ways), 1e-3)
    residuals = []
    for offsets in both_ways:
        weight = np.clip(offsets.apart_m / usual_m, _LEAST_WEIGHT, _MOST_WEIGHT) ** power
        weight *= total / (2 * len(weight))
        along = directions(draft, offsets)
        residuals.append(Residuals(offsets.leg, offsets.part, along, offsets.off_m, weight))
    return residuals


def gauss_newton_step(
    draft: Draft, residuals: list[Residuals], smoothing: Floats | float, gain: float = 1.0
) -> Draft:
    """The draft whose inner places make the residuals smallest in the least-squares sense.

    The ends stay.

    Args:
        draft: at least two places.
        residuals: what to make small, for each of the paths that count.
        smoothing: weight against unevenness, the third differences of the places (n - 3,).
        gain: share of the step that is taken.
    """
    n = len(draft)
    if n < 3:
        return draft
    third = np.diff(np.eye(n), 3, axis=0)
    smooth = third.T @ (np.broadcast_to(smoothing, len(third))[:, None] * third)
    normal = np.kron(np.eye(2), smooth + _STILL * np.eye(n))
    force: Floats = -(smooth @ draft.places_m[:, :2]).T.ravel()
    for residual in residuals:
        more, pull = _normal_equations(draft, residual)
        normal += more
        force += pull
    inner = np.arange(1, n - 1)
    free = np.column_stack([inner, n + inner]).ravel()  # North and east of a place side by side.
    step = solve_banded(np.asarray(normal[np.ix_(free, free)], float), force[free], _BAND).reshape(n - 2, 2)
    return _stepped(draft, gain * np.pad(step, ((1, 1), (0, 0))))


def _normal_equations(draft: Draft, residual: Residuals) -> tuple[Floats, Floats]:
    """Normal matrix (2n, 2n) and force (2n,) of residuals: first norths, then easts.

    Summed over the few places that shape each point, in a fixed order, so that no library's
    number of threads changes a bit of it.
    """
    n = len(draft)
    places, share = shares(draft, residual.leg, residual.part)
    across, along = residual.weight, residual.weight * ALONG_SHARE
    keep = (along - across)[:, None] * residual.direction
    metric = keep[:, :, None] * residual.direction[:, None, :] + across[:, None, None] * np.eye(2)
    pairs = (places[:, :, None] * n + places[:, None, :]).ravel()
    both = share[:, :, None] * share[:, None, :]

    def block(i: int, j: int) -> Floats:
        summed = np.bincount(pairs, (metric[:, i, j, None, None] * both).ravel(), minlength=n * n)
        return np.asarray(summed.reshape(n, n), float)

    cross = block(0, 1)
    pull = np.einsum("mij,mj->mi", metric, residual.off_m)
    force = [np.bincount(places.ravel(), (share * pull[:, i, None]).ravel(), minlength=n) for i in (0, 1)]
    return np.block([[block(0, 0), cross], [cross, block(1, 1)]]), np.concatenate(force)


def _stepped(draft: Draft, step_m: Floats) -> Draft:
    size = np.linalg.norm(step_m, axis=1, keepdims=True)
    places = draft.places_m.copy()
    places[:, :2] += step_m * np.minimum(1.0, _LONGEST_STEP_M / np.maximum(size, 1e-9))
    return replace(draft, places_m=places)


def with_fitted_heights(draft: Draft, leg: Indices, part: Floats, up_m: Floats) -> Draft:
    """The draft with the heights that follow ``up_m`` (m,) best at the given points of its path.

    No place is higher or lower than the recording is anywhere.
    """
    rows = weights(draft, leg, part)
    second = np.diff(np.eye(len(draft)), 2, axis=0)
    normal = rows.T @ rows + _STILL * (np.eye(len(draft)) + second.T @ second)
    start = draft.places_m[:, 2]
    height = start + np.linalg.solve(normal, rows.T @ (up_m - rows @ start))
    places = draft.places_m.copy()
    places[:, 2] = np.clip(height, up_m.min(), up_m.max())
    return replace(draft, places_m=places)

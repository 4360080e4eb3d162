"""Moving the places of a draft, its speeds kept: Gauss-Newton steps with a trust region for every place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.gauss_newton import gauss_newton_step, weighted_residuals, with_fitted_heights
from flight_replay.planning.fit.objective import Evaluation, leg_costs_m, scales_of
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import Hover, LocalTrack

CORRIDOR_M = 4.0
"""No waypoint is farther from the recording."""
STOP_CORRIDOR_M = 1.0
"""A place to stop at is no farther from where the recording hovered or ended: enough for an overshoot."""
_SMOOTHING, _MIN_SMOOTHING = 0.02, 0.003
_LEG_S = 1.4
"""Where legs are shorter than this in time, uneven places mean jerks."""
_FIRST_GAIN, _TRUST_MORE, _TRUST_LESS = 0.8, 1.3, 0.5
# Points weigh as the fourth power in the objective has it, but less where that would cost time.
_WEIGHT_POWER, _TIMED_WEIGHT_POWER = 2.0, 1.0
_LEGS_BEFORE, _LEGS_AROUND = 1, 5
"""A place shapes the leg before its own, its own, and some after it."""


def shaped(
    problem: FitProblem,
    start: Evaluation,
    hovers: dict[int, Hover],
    steps: int,
    flown: Callable[[Draft], Evaluation],
) -> Evaluation:
    """The one with the smallest path errors of the drafts that ``steps`` steps from ``start`` pass.

    A step that makes the flight around a place worse is taken back there, and a shorter one is tried:
    a draft is better in some places and worse in others after every step.

    Args:
        problem: what to fit.
        start: where the steps begin.
        hovers: the recorded hovers by the place at which they are waited for.
        steps: how many.
        flown: gives a draft as it is flown.
    """
    best, scales = start, scales_of(start)
    places, moves = start.draft.places_m, _moves_m(problem, start)
    costs = _costs_around(start, scales)
    gain = np.full(len(places), _FIRST_GAIN)
    for _ in range(steps):
        moved = replace(start.draft, places_m=places + gain[:, None] * moves, speed_m_s=best.draft.speed_m_s)
        trial = flown(kept_in_corridor(moved, hovers, problem.recording))
        now = _costs_around(trial, scales)
        better = now < costs
        places = np.where(better[:, None], trial.draft.places_m, places)
        moves = np.where(better[:, None], _moves_m(problem, trial), moves)
        costs = np.where(better, now, costs)
        gain = np.where(better, np.minimum(1.0, gain * _TRUST_MORE), gain * _TRUST_LESS)
        if trial.path_cost_m < best.path_cost_m:
            best = trial
    return best


def moved_once(problem: FitProblem, evaluation: Evaluation, hovers: dict[int, Hover], gain: float) -> Draft:
    """The draft after one step of its places, of which ``gain`` is taken."""
    draft = evaluation.draft
    after = replace(draft, places_m=draft.places_m + gain * _moves_m(problem, evaluation))
    return kept_in_corridor(after, hovers, problem.recording)


def _costs_around(evaluation: Evaluation, scales_m: tuple[float, float]) -> Floats:
    """What the path errors near each place (n,) add to the objective, linear about those of ``scales_m``."""
    cost = leg_costs_m(evaluation, scales_m, whole=False)
    padded = np.pad(cost, (_LEGS_BEFORE, _LEGS_AROUND - 1 - _LEGS_BEFORE))
    return np.asarray(np.convolve(padded, np.ones(_LEGS_AROUND), "valid"))


def _moves_m(problem: FitProblem, evaluation: Evaluation) -> Floats:
    """How far each place (n, 3) ought to move."""
    draft, fixes = evaluation.draft, len(problem.recording)
    if len(draft) < 2:
        return np.zeros_like(draft.places_m)
    power = _TIMED_WEIGHT_POWER if problem.timed else _WEIGHT_POWER
    flown_share, planned_share = evaluation.path_shares
    residuals = [
        *weighted_residuals(draft, evaluation.flown, flown_share * fixes, power),
        *weighted_residuals(draft, evaluation.planned, planned_share * fixes, power),
    ]
    moved = gauss_newton_step(draft, residuals, _smoothing_weights(problem, evaluation))
    recording, there = problem.recording, evaluation.planned[0]
    if np.ptp(recording.up_m) > 0:
        moved = with_fitted_heights(moved, there.leg, there.part, recording.up_m)
    return np.asarray(moved.places_m - draft.places_m)


def _smoothing_weights(problem: FitProblem, evaluation: Evaluation) -> Floats:
    """Weights (n - 3,) against unevenness: where legs are short in time, uneven places mean jerks."""
    count = len(evaluation.draft)
    if not problem.timed or count < 4:
        return np.full(max(count - 3, 0), _MIN_SMOOTHING)
    three_s = np.convolve(np.diff(evaluation.passed_s), np.ones(3) / 3, "valid")
    return np.asarray(_MIN_SMOOTHING + _SMOOTHING * np.minimum(1.0, (_LEG_S / np.maximum(three_s, 0.1)) ** 6))


def kept_in_corridor(draft: Draft, hovers: dict[int, Hover], recording: LocalTrack) -> Draft:
    """The draft with no place farther from the recording than ``CORRIDOR_M``, none to stop at than less."""
    places = draft.places_m.copy()
    feet = recording.nearest_m(places[:, :2])
    farthest_m = np.full((len(places), 1), CORRIDOR_M)
    for place, hover in hovers.items():
        feet[place] = recording.north_east_m[hover.first : hover.last + 1].mean(axis=0)
        farthest_m[place] = STOP_CORRIDOR_M
    feet[-1], farthest_m[-1] = recording.north_east_m[-1], STOP_CORRIDOR_M
    off = places[:, :2] - feet
    apart = np.linalg.norm(off, axis=1, keepdims=True)
    places[:, :2] = feet + off * np.minimum(1.0, farthest_m / np.maximum(apart, 1e-9))
    return replace(draft, places_m=places)

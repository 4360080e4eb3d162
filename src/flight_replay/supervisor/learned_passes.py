"""Learns from whole passes where targets have to be, so that the next pass is nearer to the reference.

What a vehicle misses by in the same way each time, a displacement of its targets by as much takes out:
iterative learning. What is farther off is at a limit, which no displacement of targets moves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.reference_motion import ReferenceMotion, SmoothMotion, motion_through

_STEP_S = 0.1
_SMOOTHED_S = 0.4  # Standard deviation of the weights: what changes faster is noise, or jerk.
_AT_A_LIMIT_M, _AROUND_S = 0.75, 1.0
_MOST_M = 1.0
_EDGE_S = 2.0  # At both ends the vehicle is at rest on the reference itself.


class LearnedPasses:
    """The displacement of targets that the passes so far have taught."""

    def __init__(self, reference: ReferenceMotion) -> None:
        self._times_s = reference.times_s(_STEP_S)
        self._share = 1.0
        self._best_m = np.inf
        self._best = self._missed = np.zeros((len(self._times_s), 3))
        self._flown = self._best

    def learn(self, misses: Sequence[tuple[float, Floats]]) -> SmoothMotion:
        """The displacement for the next pass.

        A pass that was worse than the best teaches only that less should have been changed since that.

        Args:
            misses: of the last pass, which flew the displacement of before: the recording's time, and
                from where the vehicle was to where it was to be (3,).
        """
        missed, mean_m = self._smoothed(misses), mean_miss_m(misses)
        if mean_m < self._best_m:
            self._best_m, self._best, self._missed = mean_m, self._flown, missed
        else:
            self._share /= 2
        wanted = self._best + self._share * self._missed
        length = np.linalg.norm(wanted, axis=1, keepdims=True)
        self._flown = wanted * np.minimum(1.0, _MOST_M / np.maximum(length, 1e-9))
        return motion_through(self._times_s, self._flown)

    def _smoothed(self, misses: Sequence[tuple[float, Floats]]) -> Floats:
        """What was missed (n, 3) at the times of the displacement, nothing where it was at a limit."""
        times_s, step_s = self._times_s, self._times_s[1] - self._times_s[0]
        if not misses:
            return np.zeros((len(times_s), 3))
        at_s, missed = np.array([at_s for at_s, _ in misses]), np.array([miss for _, miss in misses])
        order = np.argsort(at_s, kind="stable")
        known = np.column_stack([np.interp(times_s, at_s[order], axis) for axis in missed[order].T])
        around = np.ones(2 * int(_AROUND_S / step_s) + 1)
        limited = np.linalg.norm(known, axis=1) > _AT_A_LIMIT_M
        known[np.convolve(limited, around, "same") > 0] = 0.0
        ends_s = np.minimum(times_s - times_s[0], times_s[-1] - times_s)
        known *= np.clip(ends_s / _EDGE_S, 0.0, 1.0)[:, None]
        offsets_s = step_s * np.arange(-int(4 * _SMOOTHED_S / step_s), int(4 * _SMOOTHED_S / step_s) + 1)
        weights = np.exp(-0.5 * (offsets_s / _SMOOTHED_S) ** 2)
        smooth = [np.convolve(axis, weights / weights.sum(), "same") for axis in known.T]
        return np.column_stack(smooth)


def mean_miss_m(misses: Sequence[tuple[float, Floats]]) -> float:
    """How far from the reference a pass was on average."""
    return float(np.mean([np.linalg.norm(miss) for _, miss in misses])) if misses else np.inf

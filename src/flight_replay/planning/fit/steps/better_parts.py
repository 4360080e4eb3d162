"""Where a draft is better for a step that made it worse as a whole."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.planning.fit.objective import Evaluation, leg_costs_m, scales_of

_DECIMALS = 9
"""Last bits would tell where to change between legs that are the same in both."""
_SWITCH_M = 0.001
"""What it costs to go on from a draft's places to a trial's: what is between them is neither's."""


def places_better(before: Evaluation, trial: Evaluation) -> Flags:
    """The places (n,) that had better be where a trial has them.

    Args:
        before: a draft as it is flown, of n places.
        trial: the same with places, speeds or waits changed.
    """
    scales_m = scales_of(before)
    costs_m = np.stack([leg_costs_m(each, scales_m, whole=before.timed) for each in (before, trial)])
    return np.asarray(cheapest_sequence(costs_m.round(_DECIMALS), _SWITCH_M) == 1)


def cheapest_sequence(costs: Floats, switch: float) -> Indices:
    """Which of k rows of costs (k, n) to take in each column (n,), each change of row at a price.

    A shortest path, found from the first column to the last (Viterbi, 1967).
    """
    rows, columns = costs.shape
    come, before = costs[:, 0], np.zeros((columns, rows), np.intp)
    own = np.arange(rows)
    for column in range(1, columns):
        least = int(come.argmin())
        before[column] = np.where(come <= come[least] + switch, own, least)
        come = np.minimum(come, come[least] + switch) + costs[:, column]
    taken = np.empty(columns, np.intp)
    taken[-1] = come.argmin()
    for column in range(columns - 1, 0, -1):
        taken[column - 1] = before[column, taken[column]]
    return taken

"""The least sum of costs by one choice per row that never goes back."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest

from flight_replay.geometry.monotone_path import cheapest_monotone_path


@pytest.mark.parametrize("seed", range(20))
def test_no_other_forward_choice_costs_less(seed: int) -> None:
    """Against every possible choice, with bands and without."""
    chance = np.random.default_rng(seed)
    costs = chance.random((5, 9))
    low = np.sort(chance.integers(0, 4, 5)) * (seed % 2)
    high = np.maximum(np.sort(chance.integers(5, 10, 5)), 9 * ((seed + 1) % 2))
    chosen = cheapest_monotone_path(lambda rows, where: costs[rows, where].copy(), low, high)
    assert (np.diff(chosen) >= 0).all()
    assert ((low <= chosen) & (chosen < high)).all()
    possible = [
        sum(costs[row, column] for row, column in enumerate(columns))
        for columns in combinations_with_replacement(range(9), 5)
        if all(low[row] <= column < high[row] for row, column in enumerate(columns))
    ]
    assert costs[np.arange(5), chosen].sum() == pytest.approx(min(possible))


def test_bands_that_only_touch_are_followed() -> None:
    """Rows in blocks of their own, whose bands share a single column with the next block's."""
    rows = 100
    low = np.arange(rows) * 3
    high = low + 4
    chosen = cheapest_monotone_path(_apart, low, high)
    assert chosen.tolist() == (low + 2).tolist()


def _apart(some: slice, where: slice) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Costs that are least at the third column of each row's band."""
    wanted = np.arange(100)[some] * 3 + 2
    return np.abs(np.arange(where.start, where.stop)[None, :] - wanted[:, None]).astype(float)

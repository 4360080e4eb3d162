"""The least sum of costs by one choice per row that never goes back."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest

from flight_replay.geometry.arrays import Indices
from flight_replay.geometry.monotone_path import cheapest_monotone_path, cheapest_monotone_path_in_band

Costs = np.ndarray[tuple[int, int], np.dtype[np.float64]]


@pytest.mark.parametrize("banded_below", [False, True])
@pytest.mark.parametrize("banded_above", [False, True])
@pytest.mark.parametrize("seed", range(10))
def test_no_other_monotone_choice_costs_less(seed: int, banded_below: bool, banded_above: bool) -> None:
    """Against every possible choice, with bounds on either side and without."""
    chance = np.random.default_rng(seed)
    costs = chance.random((5, 9))
    low = np.sort(chance.integers(0, 4, 5)) * banded_below
    high = np.sort(chance.integers(5, 10, 5)) if banded_above else np.full(5, 9)
    chosen = cheapest_monotone_path(lambda rows, where: costs[rows, where].copy(), low, high)
    assert (np.diff(chosen) >= 0).all()
    assert ((low <= chosen) & (chosen < high)).all()
    possible = [
        sum(costs[row, column] for row, column in enumerate(columns))
        for columns in combinations_with_replacement(range(9), 5)
        if all(low[row] <= column < high[row] for row, column in enumerate(columns))
    ]
    assert costs[np.arange(5), chosen].sum() == pytest.approx(min(possible))


@pytest.mark.parametrize("seed", range(10))
def test_many_rows_cost_as_little_as_one_row_after_the_other(seed: int) -> None:
    """Rows are looked at in blocks whose columns move on; the sum is that of a plain search."""
    chance = np.random.default_rng(seed)
    rows, columns = 150, 120
    costs = chance.random((rows, columns)) + 0.05 * np.abs(np.arange(rows)[:, None] - np.arange(columns))
    low = np.sort(chance.integers(0, columns - 1, rows))
    high = np.minimum(np.maximum.accumulate(low + chance.integers(1, 30, rows)), columns)
    high = np.maximum(high, np.append(low[1:] + 1, 0))
    chosen = cheapest_monotone_path(lambda some, where: costs[some, where].copy(), low, high)
    assert (np.diff(chosen) >= 0).all()
    assert ((low <= chosen) & (chosen < high)).all()
    assert costs[np.arange(rows), chosen].sum() == pytest.approx(smallest_sum(costs, low, high))


@pytest.mark.parametrize("noise", [0.0, 2.0, 6.0])
@pytest.mark.parametrize("seed", range(5))
def test_rows_that_go_back_are_searched_together(seed: int, noise: float) -> None:
    """In narrow bands the sum is that of the search of all rows, however often they go back."""
    chance = np.random.default_rng(seed)
    rows, columns = 150, 200
    wanted = np.arange(rows) + 20 + noise * chance.standard_normal(rows)
    costs = np.abs(np.arange(columns) - wanted[:, None])
    low = np.arange(rows)
    high = np.minimum(low + 41, columns)
    chosen = cheapest_monotone_path_in_band(
        lambda some, where: costs[some, where].copy(), cheapest(costs, low, high), low, high
    )
    assert (np.diff(chosen) >= 0).all()
    assert ((low <= chosen) & (chosen < high)).all()
    assert costs[np.arange(rows), chosen].sum() == pytest.approx(smallest_sum(costs, low, high))


def cheapest(costs: Costs, low: Indices, high: Indices) -> Indices:
    """The cheapest column of each row by itself."""
    rows = zip(costs, low, high, strict=True)
    return np.array([first + row[first:end].argmin() for row, first, end in rows])


def smallest_sum(costs: Costs, low: Indices, high: Indices) -> float:
    """The sum of costs of the best choice, found row by row over all columns."""
    column, best = np.arange(costs.shape[1]), np.zeros(costs.shape[1])
    for row, first, end in zip(costs, low, high, strict=True):
        allowed = (first <= column) & (column < end)
        best = np.minimum.accumulate(best) + np.where(allowed, row, np.inf)
    return float(best.min())


def test_bands_that_only_touch_are_followed() -> None:
    """Rows in blocks of their own, whose bands share a single column with the next block's."""
    rows = 100
    low = np.arange(rows) * 3
    high = low + 4
    chosen = cheapest_monotone_path(_apart, low, high)
    assert chosen.tolist() == (low + 2).tolist()


def test_later_rows_may_go_on_to_columns_that_earlier_ones_did_not_have() -> None:
    """It costs what the cheapest column up to there did: here the last one of 32 rows."""
    costs = np.zeros((33, 8))
    costs[:32, :3] = 1.0
    costs[32, :4] = 5.0
    low, high = np.zeros(33, np.intp), np.append(np.full(32, 4), 8)
    chosen = cheapest_monotone_path(lambda some, where: costs[some, where].copy(), low, high)
    assert chosen[:32].tolist() == [3] * 32
    assert chosen[32] >= 4


def _apart(some: slice, where: slice) -> Costs:
    """Costs that are least at the third column of each row's band."""
    wanted = np.arange(100)[some] * 3 + 2
    return np.abs(np.arange(where.start, where.stop)[None, :] - wanted[:, None]).astype(float)


def test_rows_searched_together_do_not_go_back_behind_those_before() -> None:
    """Two rows that cross end behind their cheapest columns; two more that cross begin there."""
    costs = np.ones((4, 10))
    costs[0, 5] = costs[1, 1] = costs[2, 9] = costs[3, 7] = 0.0
    costs[1, 7] = costs[2, 6] = 0.1
    low, high = np.zeros(4, np.intp), np.full(4, 10)
    chosen = cheapest_monotone_path_in_band(
        lambda some, where: costs[some, where].copy(), cheapest(costs, low, high), low, high
    )
    assert (np.diff(chosen) >= 0).all()

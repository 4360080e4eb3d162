"""The normal equations of weighted least squares, in blocks of rows."""

import numpy as np
import pytest

from flight_replay.planning.fit.solvers.normal_equations import normal_equations


@pytest.mark.parametrize("groups", [1, 2])
@pytest.mark.parametrize("rows", [1, 64, 300])
def test_they_are_those_of_the_whole_matrix(groups: int, rows: int) -> None:
    """Whatever is zero, and however many rows there are."""
    random = np.random.default_rng(rows)
    columns = [random.normal(size=(7, rows)) * (random.random((7, rows)) < 0.1) for _ in range(groups)]
    weights, right = random.random(rows), random.normal(size=rows)
    matrix = np.concatenate(columns).T
    parts = [np.split(group, [rows // 3, rows // 2], axis=1) for group in columns]
    normal, force = normal_equations(parts, weights, right)
    assert np.allclose(normal, matrix.T @ (weights[:, None] * matrix))
    assert np.allclose(force, matrix.T @ (weights * right))


def test_columns_of_one_group_may_be_zero_where_those_of_another_are_not() -> None:
    """A change to one side may do nothing where that to the other does."""
    one, other = np.zeros((3, 100)), np.zeros((3, 100))
    one[0, :50], other[2, 20:] = 1.0, 2.0
    normal, _ = normal_equations([[one], [other]], np.ones(100), np.zeros(100))
    assert normal[0, 5] == normal[5, 0] == 60.0
    assert normal[0, 0] == 50.0


def test_where_nothing_changes_anything_they_are_zero() -> None:
    """A matrix of zeros."""
    normal, force = normal_equations([[np.zeros((2, 70))]], np.ones(70), np.ones(70))
    assert not normal.any()
    assert not force.any()

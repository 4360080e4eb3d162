"""The smallest value of a quadratic function of numbers that are not negative."""

import numpy as np
import pytest
from scipy.optimize import nnls

from flight_replay.planning.fit.solvers import nonnegative
from flight_replay.planning.fit.solvers.nonnegative import smallest_nonnegative


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("patience", [0, 3])
def test_it_is_what_scipy_finds(seed: int, patience: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where all that is wrong is exchanged one by one."""
    monkeypatch.setattr(nonnegative, "_PATIENCE", patience)
    random = np.random.default_rng(seed)
    rows, aims = random.normal(size=(40, 25)), random.normal(size=40)
    expected, _ = nnls(rows, aims)
    found = smallest_nonnegative(rows.T @ rows, rows.T @ aims)
    assert found.min() >= 0.0
    assert np.allclose(found, expected, atol=1e-9)


def test_without_a_force_nothing_moves() -> None:
    """All are zero, and no pivot is needed."""
    assert not smallest_nonnegative(np.eye(3), np.zeros(3)).any()


def test_it_gives_up_with_numbers_that_are_not_negative(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where pivots do not end, what is there is limited to what is allowed."""
    monkeypatch.setattr(nonnegative, "_MOST_PIVOTS", 1)
    found = smallest_nonnegative(np.array([[1.0, 0.9], [0.9, 1.0]]), np.array([1.0, 0.1]))
    assert (found >= 0.0).all()

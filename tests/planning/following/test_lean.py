"""Bounds of the lean: acceleration and drag together, more along the way than across it."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.planning.drag import Drag
from flight_replay.planning.following.lean import MostThrust, lean_bound
from flight_replay.planning.smoothing import Bound, Knots

KNOTS = Knots.between(0.0, 0.5, 0.25)
NO_DRAG = Drag(0.0, 0.0)


def _coefficients(acceleration_m_s2: tuple[float, float]) -> np.ndarray:
    """Those of a motion with one acceleration."""
    steps = np.arange(KNOTS.size)[:, None] * KNOTS.step_s
    return np.asarray(steps**2 / 2 * np.array(acceleration_m_s2))


def _lengths(bound: Bound, coefficients: np.ndarray) -> np.ndarray:
    """What is bounded, at the knots, as a share of the most."""
    vectors = np.column_stack([rows @ coefficients.T.ravel() for rows in bound.rows]) + bound.offset
    return np.asarray(np.linalg.norm(vectors, axis=1) / bound.most)


def test_drag_takes_its_part_of_the_lean() -> None:
    drag = Drag(0.2, 0.03)
    velocity = np.array([[3.0, 4.0], [0.0, 0.0], [-6.0, 1.0]])
    step = 1e-6
    for axis in range(2):
        moved = velocity + step * np.eye(2)[axis]
        change = (drag.acceleration_m_s2(moved) - drag.acceleration_m_s2(velocity)) / step
        assert drag.slope_per_s(velocity)[:, :, axis] == pytest.approx(change, abs=1e-4)
    coefficients = np.random.default_rng(1).normal(size=(KNOTS.size, 2))
    at_knots = KNOTS.derivative(1) @ coefficients
    bound = lean_bound(KNOTS, drag, at_knots, MostThrust(5.0, 5.0))
    lean = np.column_stack([rows @ coefficients.T.ravel() for rows in bound.rows]) + bound.offset
    wanted = KNOTS.derivative(2) @ coefficients + drag.acceleration_m_s2(at_knots)
    assert lean == pytest.approx(wanted)


@pytest.mark.parametrize("way", [(0.0, 1.0), (0.6, -0.8), (-0.8, -0.6)])
def test_more_thrust_along_the_way_than_across_it(way: tuple[float, float]) -> None:
    fast_m_s = np.tile(100.0 * np.array(way), (KNOTS.spans + 1, 1))
    bound = lean_bound(KNOTS, NO_DRAG, fast_m_s, MostThrust(along_m_s2=5.0, across_m_s2=4.0))
    along, across = _coefficients((5.0 * way[0], 5.0 * way[1])), _coefficients((-4.0 * way[1], 4.0 * way[0]))
    for most in (along, -along, across, -across):
        assert _lengths(bound, most) == pytest.approx(1.0, abs=1e-3)
    assert _lengths(bound, 0.8 * along + 0.6 * across) == pytest.approx(1.0, abs=1e-3)


def test_a_vehicle_that_hovers_may_go_anywhere_alike() -> None:
    still_m_s = np.zeros((KNOTS.spans + 1, 2))
    bound = lean_bound(KNOTS, NO_DRAG, still_m_s, MostThrust(along_m_s2=5.0, across_m_s2=4.0))
    for turned in np.linspace(0.0, 6.0, 7):
        towards = _coefficients((4.0 * np.cos(turned), 4.0 * np.sin(turned)))
        assert _lengths(bound, towards) == pytest.approx(1.0)


def test_drag_counts_as_thrust_along_the_way() -> None:
    drag = Drag(0.05, 0.0)
    fast_m_s = np.tile([0.0, 100.0], (KNOTS.spans + 1, 1))
    coefficients = fast_m_s[0] * np.arange(KNOTS.size)[:, None] * KNOTS.step_s
    bound = lean_bound(KNOTS, drag, fast_m_s, MostThrust(along_m_s2=5.0, across_m_s2=4.0))
    assert _lengths(bound, coefficients) == pytest.approx(1.0, abs=1e-3)

"""The convex programme on motions whose best answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.planning.smoothing import Knots, Samples, length_bound, nearest_motion


def _samples(times_s: np.ndarray, places_m: np.ndarray) -> Samples:
    return Samples(times_s, places_m, np.full(len(times_s), 0.1))


def test_a_motion_that_can_be_flown_is_kept() -> None:
    times_s = np.arange(0.0, 20.0, 0.1)
    places = np.column_stack([10 * np.sin(0.3 * times_s), 10 * np.cos(0.3 * times_s)])
    knots = Knots.between(-5.0, 25.0, 0.25)
    found = nearest_motion(knots, _samples(times_s, places), [length_bound(knots, 2, 2, 5.0)], 1e-4)
    assert np.abs(knots.values(times_s) @ found - places).max() < 0.02


def test_bounds_hold_between_knots_too() -> None:
    times_s = np.arange(0.0, 20.0, 0.1)
    places = np.column_stack([np.where(times_s > 10, 30.0, 0.0), np.zeros(len(times_s))])
    knots = Knots.between(-5.0, 25.0, 0.25)
    bounds = [length_bound(knots, 2, 2, 2.0), length_bound(knots, 3, 2, 1.5)]
    spline = knots.spline(nearest_motion(knots, _samples(times_s, places), bounds, 1e-3))
    fine_s = np.linspace(-5.0, 25.0, 5000)
    assert np.linalg.norm(spline.derivative(2)(fine_s), axis=1).max() <= 2.0 + 1e-5
    assert np.linalg.norm(spline.derivative(3)(fine_s), axis=1).max() <= 1.5 + 1e-5
    for end_s in (-5.0, 25.0):
        assert np.abs(spline.derivative(1)(end_s)).max() < 1e-6
        assert np.abs(spline.derivative(2)(end_s)).max() < 1e-6


def test_never_below_the_least() -> None:
    times_s = np.arange(0.0, 20.0, 0.1)
    heights = (3.0 + np.sin(times_s))[:, None]
    knots = Knots.between(-5.0, 25.0, 0.25)
    found = nearest_motion(knots, _samples(times_s, heights), [], 1e-4, least=2.5)
    assert knots.spline(found)(np.linspace(-5, 25, 3000)).min() >= 2.5 - 1e-6


def test_bounds_that_nothing_keeps_are_told() -> None:
    knots = Knots.between(0.0, 10.0, 0.25)
    samples = _samples(np.arange(0.0, 10.0), np.zeros((10, 1)))
    impossible = length_bound(knots, 1, 1, -1.0)
    with pytest.raises(MissionError, match="choose a part"):
        nearest_motion(knots, samples, [impossible], 1e-3)

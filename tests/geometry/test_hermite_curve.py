"""ArduCopter's spline curve: its ends, its tangents, and how many lines draw it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.hermite_curve import curve_weights, steps_within, tangent_scale
from flight_replay.geometry.polyline import nearest_on_segments
from flight_replay.simulator.navigation.hermite import Ends, hermite

VECTORS = arrays(float, (4, 3), elements=st.floats(-50, 50, width=32))


def curve(ends: Floats, t: Floats) -> Floats:
    """Points of the curve with ends (origin, destination, leaving, arriving), tangents as they are."""
    return np.asarray(curve_weights(t) @ ends)


def test_a_curve_has_its_ends_and_tangents() -> None:
    """It begins at its origin along one tangent, and ends at its destination along the other."""
    ends = np.array([[1.0, 2.0], [7.0, -3.0], [4.0, 8.0], [-5.0, 1.0]])
    begin, after, before, end = curve(ends, np.array([0.0, 1e-6, 1 - 1e-6, 1.0]))
    assert begin == pytest.approx(ends[0])
    assert end == pytest.approx(ends[1])
    assert (after - begin) / 1e-6 == pytest.approx(ends[2], abs=1e-4)
    assert (end - before) / 1e-6 == pytest.approx(ends[3], abs=1e-4)


@settings(max_examples=50)
@given(VECTORS)
def test_the_simulator_flies_the_same_curve(ends: Floats) -> None:
    """The simulator's coefficients, made one leg at a time with plain numbers, give the same points."""
    origin, destination, leaving, arriving = ends
    chord = destination - origin
    scale = tangent_scale(chord[None], leaving[None], arriving[None])
    scaled = np.stack([origin, destination, scale * leaving, scale * arriving])
    t = np.linspace(0, 1, 11)
    flown = np.vander(t, 4, increasing=True) @ np.array(hermite(Ends(*map(tuple, ends.tolist()))))
    assert curve(scaled, t) == pytest.approx(flown, abs=1e-9)


def test_tangents_longer_than_four_chords_are_scaled_down() -> None:
    """Both shrink alike until together they are four chords long; shorter ones stay, and none at all too."""
    chord = np.array([[1.0, 0, 0], [1.0, 0, 0], [0, 0, 0]])
    leaving = np.array([[0, 30.0, 0], [0, 3.0, 0], [0, 0, 0]])
    arriving = np.array([[0, 0, 50.0], [0, 0, 1.0], [0, 0, 0]])
    assert tangent_scale(chord, leaving, arriving) == pytest.approx([4 / 80, 1, 1])


@pytest.mark.parametrize("tolerance_m", [0.001, 0.02, 0.5])
def test_as_many_steps_as_the_tolerance_needs(tolerance_m: float) -> None:
    """Lines over these steps lie within the tolerance, and over four fifths as many no longer do."""
    ends = np.array([[0, 0], [20.0, 5], [30.0, 0], [0, 30.0]])
    legs = ends[1:2] - ends[:1], ends[2:3], ends[3:]
    (steps,) = steps_within(*legs, tolerance_m)
    assert largest_gap_m(ends, steps) <= tolerance_m < largest_gap_m(ends, int(0.8 * steps))


def largest_gap_m(ends: Floats, steps: int) -> float:
    """How far the curve is from the lines over so many steps, m."""
    t = np.linspace(0, 1, steps + 1)
    lines, fine = curve(ends, t), curve(ends, np.linspace(0, 1, 20 * steps + 1))
    apart = nearest_on_segments(fine[:, None], lines[:-1], np.diff(lines, axis=0))[1]
    return float(apart.min(axis=1).max())


def test_a_straight_curve_is_one_line() -> None:
    """A chord with its own third as tangents is drawn in one step, a leg without length too."""
    chord = np.array([[9.0, 0, 0], [0, 0, 0]])
    assert steps_within(chord, chord, chord, 0.001).tolist() == [1, 1]

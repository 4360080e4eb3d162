"""One leg's curve: the same as that of many legs at once."""

import numpy as np
import pytest

from flight_replay.geometry.hermite_curve import curve_weights, tangent_scale, weights_of_steps
from flight_replay.geometry.scalar.hermite_leg import points_on_leg, tangent_factor
from flight_replay.geometry.scalar.segments import places_of


@pytest.mark.parametrize("seed", range(10))
def test_one_leg_is_scaled_and_drawn_as_many_are(seed: int) -> None:
    """With tangents of any length, also where chord and tangents have none."""
    ends = np.random.default_rng(seed).normal(0, 10, (4, 3))
    ends[1:] *= seed % 3
    origin, destination, leaving, arriving = places_of(ends.tolist())
    chord = (ends[1] - ends[0]) * (seed % 2)
    factor = tangent_factor(places_of([chord.tolist()])[0], leaving, arriving)
    assert factor == pytest.approx(tangent_scale(chord[None], ends[2:3], ends[3:])[0], abs=1e-12)
    drawn = points_on_leg(origin, destination, leaving, arriving, weights_of_steps(8))
    assert np.array(drawn) == pytest.approx(curve_weights(np.linspace(0, 1, 9)) @ ends, abs=1e-9)

"""What legs between knots cost: the sums of the formulas, written with arrays."""

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.hermite_curve import curve_weights, tangent_scale, weights_of_steps
from flight_replay.geometry.polyline import lengths_along_m, nearest_on_segments, segment_lengths_m
from flight_replay.planning.fit.scalar.knot_cost import CandidateKnots, KnotCost

FIXES, AROUND = 60, 2
FIRST, LAST = [0, 6, 14, 14, 30, 41, 59], [0, 6, 14, 14, 35, 41, 59]
STOPS = [True, False, False, False, True, False, True]
STRAIGHT = [False, False, True, False, True, False, False]
WEIGHTS = curve_weights(np.linspace(0, 1, 13))


def curve_m(places_m: Floats, before: int, a: int, b: int, after: int) -> Floats:
    """The curve of a leg between places, or 13 points of a straight line."""
    origin, destination = places_m[a], places_m[b]
    if STRAIGHT[b]:
        return np.asarray(np.linspace(origin, destination, 13))
    chord = destination - origin
    leaving = 0 * chord if STOPS[a] else (origin if STRAIGHT[a] else destination) - places_m[before]
    arriving = 0 * chord if STOPS[b] else places_m[after] - places_m[b if STRAIGHT[after] else a]
    (scale,) = tangent_scale(chord[None], leaving[None], arriving[None])
    return np.asarray(WEIGHTS @ np.array([origin, destination, scale * leaving, scale * arriving]))


def nearest_m(points_m: Floats, line_m: Floats) -> Floats:
    """How far points are from a line."""
    apart_m = nearest_on_segments(points_m[:, None], line_m[:-1], np.diff(line_m, axis=0))[1]
    return np.asarray(apart_m.min(axis=1))


@pytest.mark.parametrize("axes", [2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_a_leg_costs_what_the_formulas_say(seed: int, axes: int) -> None:
    """Both ways between curve and fixes, and unevenness; without fixes between its ends, too."""
    random = np.random.default_rng(seed)
    fixes_m = random.normal(0, 2, (FIXES, axes)).cumsum(axis=0)
    time_s, along_m = random.uniform(0.1, 0.5, FIXES).cumsum(), lengths_along_m(fixes_m)
    places_m = fixes_m[FIRST] + random.normal(0, 0.5, (len(FIRST), axes))
    knots = CandidateKnots(places_m.tolist(), FIRST, LAST, STOPS, STRAIGHT)
    columns = (fixes_m.tolist(), time_s.tolist(), along_m.tolist())
    cost = KnotCost(knots, columns, weights_of_steps(12), 0.7, 0.3)
    for a in range(len(FIRST) - 1):
        line_m, begin, end = curve_m(places_m, a - 1, a, a + 1, a + 2), LAST[a], FIRST[a + 1]
        there = (nearest_m(fixes_m[begin + 1 : end + 1], line_m) ** 4).sum() / FIXES
        near = fixes_m[max(begin - AROUND, 0) : end + AROUND + 1]
        powers = nearest_m(line_m, near) ** 4
        back = ((powers[1:] + powers[:-1]) / 2 * segment_lengths_m(line_m)).sum() / along_m[-1]
        times, lengths = time_s[begin : end + 1], along_m[begin : end + 1]
        even = np.interp(times, times[[0, -1]], lengths[[0, -1]])
        expected = 0.7 * (there + back) + 0.3 * np.abs(even - lengths).sum()
        assert cost.leg_m(a - 1, a, a + 1, a + 2) == pytest.approx(expected, rel=1e-9)

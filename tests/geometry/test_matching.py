"""Fixes matched to a path going forwards only."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flight_replay.geometry import matching
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.distances import path_errors_m
from flight_replay.geometry.matching import match_in_order

PLACES = st.floats(-20, 20, allow_nan=False, width=32)


def wander(seed: int, points: int, step_m: float) -> Floats:
    """A way that turns at random."""
    heading = np.cumsum(np.random.default_rng(seed).normal(0, 0.3, points))
    return np.cumsum(step_m * np.stack([np.cos(heading), np.sin(heading)], axis=1), axis=0)


def scattered(path: Floats, fixes: int, noise_m: float, seed: int = 1) -> Floats:
    """Fixes along a path, in order, with noise."""
    where = np.linspace(0, len(path) - 1, fixes)
    on_path = np.stack([np.interp(where, np.arange(len(path)), path[:, k]) for k in (0, 1)], axis=1)
    return on_path + np.random.default_rng(seed).normal(0, noise_m, (fixes, 2))


def smallest_sum(fixes: Floats, path: Floats, step_m: float = 0.004) -> float:
    """The smallest sum of distances over points of the path, going forwards."""
    lengths = np.append(0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
    fine = np.append(np.arange(0, lengths[-1], step_m), lengths[-1])
    points = np.stack([np.interp(fine, lengths, path[:, k]) for k in (0, 1)], axis=1)
    best = np.zeros(len(points))
    for fix in fixes:
        best = np.minimum.accumulate(best) + np.hypot(*(points - fix).T)
    return float(best.min())


def test_a_fix_beside_a_line_is_as_far_as_the_line() -> None:
    """Distances are from the lines, not from their corners."""
    distances = path_errors_m([[5, 2], [8, -1], [12, 0]], [[0, 0], [10, 0]])
    assert distances == pytest.approx([2, 1, 2])


def test_matching_never_goes_back() -> None:
    """A path that returns over itself does not lend its way out to fixes of its way back."""
    path = [[0, 0], [100, 0], [100, 3], [0, 3]]
    match = match_in_order([[50.0, 0.0], [100.0, 1.0], [50.0, 0.0], [10.0, 0.0]], path)
    assert match.distance_m == pytest.approx([0, 0, 3, 3])
    assert match.along_m == pytest.approx([50, 101, 153, 193])
    assert match.segment.tolist() == [0, 1, 2, 2]


def test_fixes_that_step_back_on_one_line_share_a_place() -> None:
    """Going back 2 m along a line costs 2 m, because the match may only stand still."""
    assert path_errors_m([[5, 0], [3, 0], [6, 0]], [[0, 0], [10, 0]]).sum() == pytest.approx(2, abs=0.002)


@pytest.mark.parametrize("seed", range(6))
def test_the_matching_has_the_smallest_sum(seed: int) -> None:
    """On wandering paths the sum is the best one of a search at 4 mm, to 1 mm per fix."""
    path = wander(seed, 30, 1.5)
    fixes = scattered(path, 50, 0.8, seed)
    assert path_errors_m(fixes, path).sum() == pytest.approx(smallest_sum(fixes, path), abs=0.05)


@settings(max_examples=30, deadline=None)
@given(arrays(float, (7, 2), elements=PLACES), arrays(float, (4, 2), elements=PLACES))
def test_any_matching_is_in_order_and_no_nearer_than_the_path(fixes: Floats, path: Floats) -> None:
    """Along never falls, and no fix is nearer than the nearest place of the whole path."""
    match = match_in_order(fixes, path)
    assert (np.diff(match.along_m) >= -1e-9).all()
    alone = [path_errors_m([fix], path)[0] for fix in fixes]
    assert (match.distance_m >= np.array(alone) - 1e-9).all()
    assert match.distance_m.sum() <= smallest_sum(fixes, path, 0.02) + 0.01 * len(fixes)


def test_the_two_step_search_finds_what_the_whole_search_finds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coarse first, then within a band, gives the same matching on a path that crosses itself ten times."""
    turn = np.linspace(0, 20 * np.pi, 1200)
    eight = np.stack([50 * np.sin(turn), 25 * np.sin(2 * turn)], axis=1)
    fixes = scattered(eight, 700, 0.3)
    whole = match_in_order(fixes, eight)
    monkeypatch.setattr(matching, "MAX_PAIRS_SEARCHED_WHOLE", 1000)
    assert np.allclose(match_in_order(fixes, eight).along_m, whole.along_m)


def test_a_band_too_narrow_is_widened(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the answer touches the band's edge the band grows, until the answer is the whole search's."""
    path = wander(3, 300, 2.0)
    fixes = scattered(path, 200, 3.0)
    whole = match_in_order(fixes, path)
    for name, value in (
        ("MAX_PAIRS_SEARCHED_WHOLE", 1000),
        ("BAND_M", 0.5),
        ("COARSE_FIXES", 8),
        ("COARSE_PIECES", 12),
    ):
        monkeypatch.setattr(matching, name, value)
    assert match_in_order(fixes, path).distance_m.sum() == pytest.approx(whole.distance_m.sum(), rel=0.02)


def test_fixes_farther_apart_than_the_band_are_matched(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fix every 100 m on a straight path is matched where it lies."""
    monkeypatch.setattr(matching, "MAX_PAIRS_SEARCHED_WHOLE", 1000)
    north = np.arange(0.0, 20_001.0, 100.0)
    match = match_in_order(np.column_stack([north, np.ones(len(north))]), [[0, 0], [20_000, 0]])
    assert match.along_m == pytest.approx(north)
    assert match.distance_m == pytest.approx(np.ones(len(north)))


def test_one_point_is_a_path() -> None:
    """A path of one point takes every fix; none at all is refused, and no fixes give no distances."""
    assert path_errors_m([[3, 4], [0, 1]], [[0, 0]]) == pytest.approx([5, 1])
    assert path_errors_m(np.zeros((0, 2)), [[0, 0]]).shape == (0,)
    with pytest.raises(ValueError, match="at least one point"):
        match_in_order([[0, 0]], np.zeros((0, 2)))

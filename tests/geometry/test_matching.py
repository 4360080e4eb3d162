"""Fixes matched to a path going forwards only."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flight_replay.geometry import matching
from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.matching import distances_in_order_m, match_in_order
from flight_replay.geometry.monotone_path import cheapest_monotone_path

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
    match = match_in_order([[5, 2], [8, -1], [12, 0]], [[0, 0], [10, 0]])
    assert match.distance_m == pytest.approx([2, 1, 2])


def test_matching_never_goes_back() -> None:
    """A path that returns over itself does not lend its way out to fixes of its way back."""
    path = [[0, 0], [100, 0], [100, 3], [0, 3]]
    match = match_in_order([[50.0, 0.0], [100.0, 1.0], [50.0, 0.0], [10.0, 0.0]], path)
    assert match.distance_m == pytest.approx([0, 0, 3, 3])
    assert match.along_m == pytest.approx([50, 101, 153, 193])
    assert match.segment.tolist() == [0, 1, 2, 2]


def test_fixes_that_step_back_on_one_line_share_a_place() -> None:
    """Going back 2 m along a line costs 2 m, because the match may only stand still."""
    match = match_in_order([[5, 0], [3, 0], [6, 0]], [[0, 0], [10, 0]])
    assert match.distance_m.sum() == pytest.approx(2, abs=0.002)


@pytest.mark.parametrize("seed", range(6))
def test_the_matching_has_the_smallest_sum(seed: int) -> None:
    """On wandering paths the sum is the best one of a search at 4 mm, to 1 mm per fix."""
    path = wander(seed, 30, 1.5)
    fixes = scattered(path, 50, 0.8, seed)
    assert match_in_order(fixes, path).distance_m.sum() == pytest.approx(smallest_sum(fixes, path), abs=0.05)


@settings(max_examples=30)
@given(arrays(float, (7, 2), elements=PLACES), arrays(float, (4, 2), elements=PLACES))
def test_any_matching_is_in_order_and_no_nearer_than_the_path(fixes: Floats, path: Floats) -> None:
    """Along never falls, and no fix is nearer than the nearest place of the whole path."""
    match = match_in_order(fixes, path)
    assert (np.diff(match.along_m) >= -1e-9).all()
    alone = [match_in_order([fix], path).distance_m[0] for fix in fixes]
    assert (match.distance_m >= np.array(alone) - 1e-9).all()
    assert match.distance_m.sum() <= smallest_sum(fixes, path, 0.02) + 0.01 * len(fixes)


@dataclass
class Bands:
    """The searches that matchings made: for each, the bounds (low, high) on the column of every row."""

    searches: list[tuple[Indices, Indices]]

    @property
    def columns(self) -> int:
        """How many pieces the path of the last search had."""
        return int(self.searches[-1][1].max())


@pytest.fixture
def bands(monkeypatch: pytest.MonkeyPatch) -> Bands:
    """What is searched, while it is."""
    seen = Bands([])

    def watched(costs_of: Callable[[slice, slice], Floats], low: Indices, high: Indices) -> Indices:
        seen.searches.append((low, high))
        return cheapest_monotone_path(costs_of, low, high)

    monkeypatch.setattr(matching, "cheapest_monotone_path", watched)
    return seen


def test_a_path_that_crosses_itself_is_matched_alike_in_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coarse first, then within a band, gives the same matching on ten figures of eight."""
    turn = np.linspace(0, 20 * np.pi, 1200)
    eight = np.stack([50 * np.sin(turn), 25 * np.sin(2 * turn)], axis=1)
    fixes = scattered(eight, 700, 0.3)
    whole = match_in_order(fixes, eight)
    monkeypatch.setattr(matching, "MAX_PAIRS_SEARCHED_WHOLE", 1000)
    found = match_in_order(fixes, eight)
    assert np.allclose(found.along_m, whole.along_m)
    assert (found.segment == whole.segment).all()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_quick_matching_is_the_same_where_the_way_is_followed(seed: int, bands: Bands) -> None:
    """It looks at a coarse path first, and then only near to that."""
    path = wander(seed, 4000, 0.5)
    fixes = scattered(path, 700, 0.5)
    whole = match_in_order(fixes, path, 1.0)
    assert len(bands.searches) == 1
    quick = match_in_order(fixes, path, 1.0, quick=True)
    assert len(bands.searches) == 3
    _, coarse = bands.searches[1]
    assert (len(coarse), int(coarse.max())) == (400, 1000)
    assert quick.distance_m.sum() == pytest.approx(whole.distance_m.sum(), rel=1e-9)


@pytest.mark.parametrize(("fixes", "searches"), [(1000, 1), (1001, 2)])
def test_a_quick_matching_searches_a_million_pairs_whole(fixes: int, searches: int, bands: Bands) -> None:
    """With more, a coarse search comes first."""
    north = np.linspace(0.0, 1000.0, fixes)
    match_in_order(np.column_stack([north, 0.0 * north]), [[0, 0], [1000, 0]], 1.0, quick=True)
    assert len(bands.searches) == searches


@pytest.mark.parametrize("near_m", [10.0, 3.0, 0.0])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_matching_near_to_where_it_is_likely_is_the_same(seed: int, near_m: float) -> None:
    """However little is searched at first: where the answer touches the bound there is more."""
    path = wander(seed, 2000, 0.5)
    fixes = scattered(path, 500, 0.5)
    whole = match_in_order(fixes, path, 1.0)
    likely_m = whole.along_m + np.random.default_rng(seed).uniform(-5.0, 5.0, len(fixes))
    found = match_in_order(fixes, path, 1.0, near_m=(likely_m - near_m, likely_m + near_m))
    assert (np.diff(found.along_m) >= 0).all()
    assert found.distance_m.sum() == pytest.approx(whole.distance_m.sum(), rel=1e-3)


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 5, 7])
def test_a_band_too_narrow_is_widened(seed: int, monkeypatch: pytest.MonkeyPatch, bands: Bands) -> None:
    """Where the answer touches the band's edge the band grows, until the answer is the whole search's."""
    path = wander(seed, 300, 2.0)
    fixes = scattered(path, 200, 3.0)
    whole = match_in_order(fixes, path).distance_m.sum()
    narrow = {"MAX_PAIRS_SEARCHED_WHOLE": 1000, "BAND_M": 0.5, "COARSE_FIXES": 200, "COARSE_PIECES": 12}
    for name, value in narrow.items():
        monkeypatch.setattr(matching, name, value)
    assert match_in_order(fixes, path).distance_m.sum() == pytest.approx(whole, abs=1e-9)
    assert len(bands.searches) > 3
    monkeypatch.setattr(matching, "_widened_band", lambda *_: None)
    assert match_in_order(fixes, path).distance_m.sum() > whole + 0.1


def test_a_band_grows_only_where_the_answer_touches_it() -> None:
    """By its own width, to either side, not beyond the path's ends, and rows stay in order."""
    low, high = np.array([0, 4, 8]), np.array([6, 10, 12])
    assert matching._widened_band(np.array([0, 6, 11]), low, high, 12) is None
    grown = matching._widened_band(np.array([5, 6, 8]), low, high, 12)
    assert grown is not None
    assert [bound.tolist() for bound in grown] == [[0, 4, 4], [12, 12, 12]]
    grown = matching._widened_band(np.array([3, 9, 9]), low, high, 99)
    assert grown is not None
    assert [bound.tolist() for bound in grown] == [[0, 4, 8], [6, 16, 16]]
    grown = matching._widened_band(np.array([3, 4, 9]), np.array([2, 4, 8]), high, 12)
    assert grown is not None
    assert [bound.tolist() for bound in grown] == [[0, 0, 8], [6, 10, 12]]
    grown = matching._widened_band(np.array([1, 6, 9]), np.array([1, 4, 8]), high, 12)
    assert grown is not None
    assert [bound.tolist() for bound in grown] == [[0, 4, 8], [6, 10, 12]]


def test_a_long_path_is_searched_within_40_m_of_the_coarse_matching(bands: Bands) -> None:
    """A thousand fixes on 20 km: each is held against 80 m of path and a coarse piece, not against all."""
    fixes = np.column_stack([np.linspace(0.0, 20_000.0, 1000), np.ones(1000)])
    match = match_in_order(fixes, [[0, 0], [20_000, 0]])
    assert match.along_m == pytest.approx(fixes[:, 0])
    assert match.distance_m == pytest.approx(np.ones(1000))
    (_, coarse), (low, high) = bands.searches
    assert (len(coarse), int(coarse.max())) == (1000, 4000)
    inner = slice(10, -10)
    piece_m = 20_000.0 / bands.columns
    ahead_m = high[inner] * piece_m - fixes[inner, 0]
    behind_m = fixes[inner, 0] - low[inner] * piece_m
    assert (ahead_m >= 40.0).all() and (behind_m >= 40.0).all()
    assert np.median(ahead_m + behind_m) < 80.0 + 5.0 + 2 * piece_m


def test_many_fixes_are_matched_coarsely_by_some_of_them(bands: Bands) -> None:
    """1500 of 9000 fixes go first; those between them may lie anywhere between."""
    path = wander(4, 2000, 1.0)
    fixes = scattered(path, 9000, 0.5)
    match_in_order(fixes, path)
    (_, coarse), (low, high), *_ = bands.searches
    assert (len(coarse), len(low)) == (1500, 9000)
    assert (np.diff(low) >= 0).all() and (np.diff(high) >= 0).all()
    assert (low[1:] < high[:-1]).all()


def test_fixes_farther_apart_than_the_band_are_matched(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fix every 100 m on a straight path is matched where it lies."""
    monkeypatch.setattr(matching, "MAX_PAIRS_SEARCHED_WHOLE", 1000)
    north = np.arange(0.0, 20_001.0, 100.0)
    match = match_in_order(np.column_stack([north, np.ones(len(north))]), [[0, 0], [20_000, 0]])
    assert match.along_m == pytest.approx(north)
    assert match.distance_m == pytest.approx(np.ones(len(north)))


@pytest.mark.parametrize(
    ("fixes", "length_m", "piece_m"),
    [(10, 10.0, 0.01), (1000, 1000.0, 0.125), (1000, 5000.0, 0.25)],
    ids=["centimetres", "8 million pairs", "a quarter of a metre"],
)
def test_pieces_are_as_short_as_time_allows(
    fixes: int, length_m: float, piece_m: float, bands: Bands
) -> None:
    """Eight million pairs of fix and piece are affordable; pieces are 1 to 25 cm long."""
    match_in_order(np.zeros((fixes, 2)), [[0.0, 0.0], [length_m, 0.0]])
    assert bands.columns == pytest.approx(length_m / piece_m, abs=1)


def test_longer_pieces_are_searched_when_asked_for(bands: Bands) -> None:
    """No piece is longer than asked for, and none reaches over a corner."""
    match_in_order([[0, 0]], [[0.0, 0.0], [10.0, 0.0], [10.0, 0.5], [10.0, 3.0]], piece_m=2.0)
    assert bands.columns == 5 + 1 + 2


def test_a_path_may_stand_still() -> None:
    """Equal points make segments without length, which fixes are matched to like any other."""
    match = match_in_order([[1, 1], [4, 0], [9, 2]], [[0, 0], [0, 0], [5, 0], [5, 0], [5, 0], [10, 0]])
    assert match.distance_m == pytest.approx([1, 0, 2])
    assert match.along_m == pytest.approx([1, 4, 9])


@pytest.mark.parametrize("turned", [np.eye(2), np.array([[0.6, 0.8], [-0.8, 0.6]])], ids=["north", "aside"])
def test_crowded_fixes_share_the_best_position(turned: Floats) -> None:
    """Fixes out of order on one piece stand at one position, the one with the smallest sum of distances."""
    fixes = np.array([[2.0, 0.5], [6.0, 3.0], [5.0, 0.1], [4.0, 1.0], [9.0, 0.0]])
    match = match_in_order(fixes @ turned, np.array([[0, 0], [10, 0]]) @ turned, piece_m=10.0)
    along = match.along_m
    assert along[0] == pytest.approx(2.0)
    assert along[4] == pytest.approx(9.0)
    assert along[1] == along[2] == along[3]
    shared = np.linspace(0, 10, 10_001)
    sums = np.hypot(fixes[1:4, :1] - shared, fixes[1:4, 1:]).sum(axis=0)
    assert along[2] == pytest.approx(shared[sums.argmin()], abs=0.005)
    assert match.distance_m == pytest.approx(np.hypot(fixes[:, 0] - along, fixes[:, 1]))


def test_two_crossed_fixes_stand_where_the_nearer_one_is() -> None:
    """Moving the one far from the line costs less."""
    match = match_in_order([[6.0, 5.0], [4.0, 0.01]], [[0, 0], [10, 0]], piece_m=10.0)
    assert match.along_m == pytest.approx([4.0, 4.0], abs=0.01)


def test_one_point_is_a_path() -> None:
    """A path of one point takes every fix; none at all is refused, and no fixes give an empty matching."""
    match = match_in_order([[3, 4], [0, 1]], [[0, 0]])
    assert match.distance_m == pytest.approx([5, 1])
    assert (match.along_m.tolist(), match.segment.tolist()) == ([0, 0], [0, 0])
    empty = match_in_order([], [[0, 0], [1, 0]])
    assert [len(column) for column in (empty.distance_m, empty.along_m, empty.segment)] == [0, 0, 0]
    with pytest.raises(ValueError, match="at least one point"):
        match_in_order([[0, 0]], np.zeros((0, 2)))


@pytest.mark.parametrize("seed", range(8))
def test_distances_of_few_points_are_those_of_the_matching(seed: int) -> None:
    """A little less, as points at one segment may be in any order; all else is in order."""
    path = wander(seed, 80, 0.2)
    fixes = scattered(path, 25, 0.3, seed)
    in_order_m = float(match_in_order(fixes, path, 1.0).distance_m.sum())
    assert 0.94 * in_order_m < distances_in_order_m(fixes, path).sum() < in_order_m + 1e-6


def test_distances_of_few_points_do_not_borrow_from_the_way_back() -> None:
    """A way out and back: each point is as far off as the way is when it is its turn."""
    there_and_back = np.array([(0.0, 0.0), (10.0, 0.0), (10.0, 2.0), (0.0, 2.0)])
    points = np.array([(2.0, 0.0), (8.0, 2.0), (7.0, 0.0), (8.0, 0.0), (2.0, 2.0)])
    assert distances_in_order_m(points, there_and_back) == pytest.approx([0.0, 2.0, 0.0, 0.0, 0.0])
    assert distances_in_order_m(points, there_and_back[:1]).tolist() == [0.0] * 5
    assert distances_in_order_m(points[:0], there_and_back).tolist() == []

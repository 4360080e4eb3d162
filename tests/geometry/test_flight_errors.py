"""The measures: the path error both ways, and the errors at equal times."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flight_replay.geometry import flight_errors as measures
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flight_errors import errors_at_equal_times, flight_errors, path_errors
from flight_replay.geometry.movement import Movement

ALONE = np.zeros((0, 2))


def movement(north_east_m: list[tuple[float, float]] | Floats, **other: Floats) -> Movement:
    """A place a second."""
    places: Floats = np.asarray(north_east_m, np.float64).reshape(-1, 2)
    n = len(places)
    columns = {"time_s": np.arange(n, dtype=float), "up_m": np.zeros(n), "heading_deg": np.full(n, np.nan)}
    columns |= other
    return Movement(columns["time_s"], places, columns["up_m"], columns["heading_deg"])


def test_an_overshoot_shows_from_the_path_only() -> None:
    """A path that goes 4 m past a corner and comes back passes all fixes."""
    corner = movement([(0, 0), (10, 0), (10, 10)])
    errors = path_errors(corner, np.array([[0, 0], [14, 0], [10, 0], [10, 10.0]]))
    assert errors.recorded_to_path.error.max() == pytest.approx(0.0, abs=1e-6)
    assert errors.path_to_recorded.error.max() == pytest.approx(4.0)


def test_a_cut_corner_shows_from_the_fixes_most() -> None:
    """A path that cuts a corner of 10 m misses its fix by the corner's height."""
    errors = path_errors(movement([(0, 0), (10, 0), (10, 10)]), np.array([[0, 0], [10, 10.0]]))
    assert errors.recorded_to_path.error.tolist() == pytest.approx([0, np.sqrt(50), 0])
    assert errors.path_to_recorded.error.max() == pytest.approx(5.0, abs=0.1)


def test_both_ways_are_matched_in_order() -> None:
    """A second lap cannot borrow the first one's line, whichever way it is measured."""
    there_and_back = np.array([[0, 0], [50, 0], [50, 3], [0, 3.0]])
    errors = path_errors(movement([(0, 0), (50, 0), (0, 0)]), there_and_back)
    assert errors.recorded_to_path.error.tolist() == pytest.approx([0, 0, 3])
    assert errors.path_to_recorded.error.max() == pytest.approx(3.0, abs=1e-3)
    on_the_way_back = errors.place_m[:, 1] > 2.9
    assert (errors.path_to_recorded.time_s[on_the_way_back] >= 1.0).all()


def test_places_are_a_quarter_of_a_metre_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Evenly along the path, both ends included; very long paths are measured less often."""
    line = np.array([[0, 0], [3, 0], [3, 4.1]])
    places = measures.spaced_places_m(line)
    steps_m = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert steps_m.max() <= measures.PLACE_SPACING_M + 1e-9
    assert places[[0, -1]].tolist() == line[[0, -1]].tolist()
    monkeypatch.setattr(measures, "MAX_PLACES", 5)
    assert len(measures.spaced_places_m(line)) == 5
    assert len(measures.spaced_places_m(line[:1])) == 1
    assert len(measures.spaced_places_m(ALONE)) == 0


def test_errors_at_equal_times() -> None:
    """Where, how high and which way at the times that both have; headings the short way round."""
    n = 5
    recorded = movement(
        [(4.0 * k, 0) for k in range(n)], up_m=np.full(n, 30.0), heading_deg=np.full(n, 350.0)
    )
    late = Movement(
        np.arange(1.0, 5.0),
        np.array([(4.0 * k, 3.0) for k in range(4)]),
        np.full(4, 28.5),
        np.full(4, 15.0),
    )
    position, height, heading = errors_at_equal_times(recorded, late)
    assert position.time_s.tolist() == [1.0, 2.0, 3.0, 4.0]
    assert position.error.tolist() == pytest.approx([5.0] * 4)
    assert height.error.tolist() == pytest.approx([1.5] * 4)
    assert heading.error.tolist() == pytest.approx([25.0] * 4)


def test_positions_are_compared_at_the_recorded_times() -> None:
    """With the flown place between two rows; the first and last flown times count, fixes beyond do not."""
    recorded = movement([(0, 0), (1, 4), (2, 8), (3, 0)])
    flown = movement([(0, 5), (3, 4), (8, 4)], time_s=np.array([-1.0, 0.0, 2.5]))
    assert errors_at_equal_times(recorded, flown)[0].error == pytest.approx([5, 4, np.hypot(5, 4)])
    part = movement([(1, 5), (3, 2)], time_s=np.array([1.0, 3.0]))
    assert errors_at_equal_times(recorded, part)[0].error == pytest.approx([1, 4.5, 2])


@pytest.mark.parametrize("side", ["recorded", "flown"])
def test_what_is_unknown_has_no_error(side: str) -> None:
    """Fixes without a height or a heading are left out of that error, and of no other."""
    known = movement([(0, 0), (1, 0), (2, 0)], heading_deg=np.zeros(3))
    unknown = movement([(0, 0), (1, 0), (2, 0)], up_m=np.array([0.0, np.nan, np.nan]))
    pair = (unknown, known) if side == "recorded" else (known, unknown)
    position, height, heading = errors_at_equal_times(*pair)
    assert (len(position), len(height), len(heading)) == (3, 1, 0)
    assert heading.statistics is None


@pytest.mark.parametrize("fixes", [0, 1])
@pytest.mark.parametrize("rows", [0, 1])
def test_hardly_anything_is_no_crash(fixes: int, rows: int) -> None:
    """No fix, no flown position, one of either."""
    errors = flight_errors(movement([(3, 4)] * fixes), movement([(0, 0)] * rows))
    expected = [5.0] if fixes and rows else []
    assert errors.path_m.recorded_to_path.error.tolist() == expected
    assert errors.path_m.path_to_recorded.error.tolist() == expected
    assert errors.position_m.error.tolist() == expected
    assert len(errors.heading_deg) == 0


def test_flights_that_have_no_time_in_common_have_no_error_at_equal_times() -> None:
    """Their paths are compared all the same."""
    recorded = movement([(0, 0), (1, 0)])
    later = movement([(0, 0), (1, 0)], time_s=np.array([60.0, 61.0]))
    errors = flight_errors(recorded, later)
    assert len(errors.position_m) == 0
    assert errors.path_m.path_to_recorded.error.tolist() == pytest.approx([0.0] * 5)


def test_only_what_lies_between_the_waypoints_is_measured() -> None:
    """Not the way to the first waypoint, nor beyond the last."""
    line = movement([(0, 0), (10, 0)])
    flown = movement([(0, -20), (0, 0), (10, 0), (10, 30)], time_s=np.array([-2.0, 0.0, 1.0, 2.0]))
    errors = flight_errors(line, flown, last_s=1.0)
    assert errors.path_m.path_to_recorded.error.max() == pytest.approx(0.0, abs=1e-6)
    assert flight_errors(line, flown).path_m.path_to_recorded.error.max() == pytest.approx(30.0)


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.integers(2, 40))
def test_a_path_through_the_fixes_has_no_error_either_way(seed: int, fixes: int) -> None:
    """The recorded line itself is 0 from the recording, however it crosses itself."""
    places = np.cumsum(np.random.default_rng(seed).normal(0, 3, (fixes, 2)), axis=0)
    errors = path_errors(movement(places), places)
    assert errors.recorded_to_path.error.max() == pytest.approx(0.0, abs=2e-3)
    assert errors.path_to_recorded.error.mean() == pytest.approx(0.0, abs=2e-3)

"""Where a vehicle was at what time."""

import numpy as np
import pytest

from flight_replay.geometry.movement import Movement


def turning(*headings_deg: float) -> Movement:
    """A second from heading to heading, going north at 2 m/s."""
    n = len(headings_deg)
    time_s = np.arange(n, dtype=float)
    return Movement(time_s, np.column_stack([2 * time_s, 0 * time_s]), np.zeros(n), np.array(headings_deg))


def test_places_lie_between_those_known() -> None:
    """Half-way in time is half-way on the ground."""
    assert turning(0, 0, 0).places_at(np.array([0.5, 2.0])).tolist() == [[1.0, 0.0], [4.0, 0.0]]


@pytest.mark.parametrize(
    ("headings_deg", "expected_deg"),
    [((350, 10), 0), ((10, 350), 0), ((90, 180), 135), ((np.nan, 20, 40), np.nan), ((0, np.nan, 40), 10)],
)
def test_headings_turn_the_short_way(headings_deg: tuple[float, ...], expected_deg: float) -> None:
    """Through north if that is shorter; one that is unknown is bridged, but not at the ends."""
    got = turning(*headings_deg).headings_at(np.array([0.5]))
    assert got.tolist() == pytest.approx([expected_deg], nan_ok=True, abs=1e-9)


def test_without_a_heading_there_is_none() -> None:
    """Not a number at all times asked for."""
    assert np.isnan(turning(np.nan, np.nan).headings_at(np.array([0.0, 0.5, 1.0]))).all()


def test_a_part_keeps_its_columns_together() -> None:
    """A slice picks the same times of each."""
    part = turning(1, 2, 3).select(slice(1, None))
    assert (len(part), part.time_s.tolist(), part.heading_deg.tolist()) == (2, [1.0, 2.0], [2.0, 3.0])

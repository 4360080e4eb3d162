"""The classic reduction of a line to its corners."""

from flight_replay.planning.fit.line_simplification import douglas_peucker
from tests.helpers.fit_tracks import FRAME, along


def test_douglas_peucker_keeps_corners() -> None:
    """A line around three corners keeps them and its ends, and no more than asked."""
    line = along([(0, 0), (40, 0), (70, 40), (10, 120)], 2.0).north_east_m(FRAME)
    kept = douglas_peucker(line, 10)
    assert kept.tolist() == [0, 80, 180, 380]
    assert len(douglas_peucker(line, 3)) == 3

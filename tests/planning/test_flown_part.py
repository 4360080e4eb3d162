"""The flown part of a log: flights joined without gaps, and what is noted."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.logs.track import Armed
from flight_replay.planning.flown_part import flown_part
from tests.helpers.fit_tracks import along, hover, joined


def test_the_flown_part_leaves_out_the_ground_and_closes_the_gap() -> None:
    """Two armed stretches are joined without the minutes between, which is said."""
    first = along([(0, 0), (30, 0)], 3.0)
    ground = replace(hover(60.0), armed=np.zeros(240, np.int8))
    second = along([(30, 0), (60, 0)], 3.0)
    apart = [
        replace(part, time_s=part.time_s + begin)
        for part, begin in ((first, 0.0), (ground, 11.0), (second, 300.0))
    ]
    part, notes = flown_part(joined(*apart))
    assert len(part) == len(first) + len(second)
    assert part.time_s[-1] == pytest.approx(20.25)
    assert notes == (f"240 of {240 + len(part)} fixes are left out: they are not part of a flight.",)


def test_a_far_join_is_said() -> None:
    """A second flight that begins 100 m away is joined by a way that nobody flew, and that is said."""
    first = along([(0, 0), (30, 0)], 3.0)
    second = along([(130, 0), (160, 0)], 3.0)
    between = replace(first.select(slice(0, 1)), time_s=np.array([20.0]), armed=np.array([Armed.NO], np.int8))
    _, notes = flown_part(joined(first, between, replace(second, time_s=second.time_s + 60)))
    assert any("Flight 2 begins 100 m" in note for note in notes)


def test_a_log_without_flights_is_taken_whole() -> None:
    """Where nothing tells flying from standing, all fixes count."""
    track = replace(hover(5.0), armed=np.zeros(20, np.int8))
    part, notes = flown_part(track)
    assert len(part) == len(track)
    assert len(notes) == 1

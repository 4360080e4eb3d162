"""The flown part of a log: flights joined without gaps, and what is noted."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.logs.track import Armed, Track
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
    assert notes == (f"Left out: 240 of {240 + len(part)} fixes, no part of a flight.",)


def test_a_far_join_is_said() -> None:
    """A second flight that begins 100 m away is joined by a way that nobody flew, and that is said."""
    first = along([(0, 0), (30, 0)], 3.0)
    second = along([(130, 0), (160, 0)], 3.0)
    between = replace(first.select(slice(0, 1)), time_s=np.array([20.0]), armed=np.array([Armed.NO], np.int8))
    _, notes = flown_part(joined(first, between, replace(second, time_s=second.time_s + 60)))
    assert any("Flight 2 begins 100 m" in note for note in notes)
    _, untold = flown_part(
        joined(first, between, replace(second, time_s=second.time_s + 60)), tell_joins=False
    )
    assert not any("Flight 2" in note for note in untold)


def landed_between(first: Track, second: Track, third: Track) -> Track:
    """Three flights with a fix on the ground after each of the first two."""
    parts = []
    for begin_s, part in ((0.0, first), (100.0, second), (200.0, third)):
        ground = replace(part.select(slice(0, 1)), armed=np.array([Armed.NO], np.int8))
        parts.append(replace(part, time_s=part.time_s + begin_s))
        parts.append(replace(ground, time_s=np.array([begin_s + 50.0])))
    return joined(*parts[:-1])


def test_a_gap_is_measured_from_the_last_fix_to_the_next_flights_first() -> None:
    """More than 50 m are noted, 40 m are not."""
    flights = (
        along([(0, 0), (20, 30)], 3.0),
        along([(20, 70), (60, 70)], 3.0),
        along([(60, -10), (0, 0)], 3.0),
    )
    _, (_, *gaps) = flown_part(landed_between(*flights))
    joins = "a straight leg that was not flown joins them."
    assert gaps == [f"Flight 3 begins 80 m from where flight 2 ended; {joins}"]


def test_the_clock_of_joined_flights_goes_on_by_one_step() -> None:
    """From flight to flight as from fix to fix; flights of one fix each have no step."""
    flight = along([(0, 0), (30, 0)], 3.0)
    part, _ = flown_part(landed_between(flight, flight, flight))
    assert np.diff(part.time_s) == pytest.approx(np.full(3 * len(flight) - 1, 0.25))
    fix = flight.select(slice(0, 1))
    assert flown_part(landed_between(fix, fix, fix))[0].time_s.tolist() == [0.0] * 3


def test_a_log_of_one_flight_alone_has_no_notes() -> None:
    """Nothing is left out."""
    assert flown_part(along([(0, 0), (30, 0)], 3.0))[1] == ()


def test_a_log_without_flights_is_taken_whole() -> None:
    """Where nothing tells flying from standing, all fixes count."""
    track = replace(hover(5.0), armed=np.zeros(20, np.int8))
    part, notes = flown_part(track)
    assert len(part) == len(track)
    assert len(notes) == 1


def test_the_clock_goes_on_as_the_tracks_from_the_first_flown_fix() -> None:
    """What was left out before it is told by the clock: when the flight began can be known."""
    parts = landed_between(*(along([(0, 0), (30, 0)], 3.0) for _ in range(3)))
    ground = replace(parts.select(slice(0, 1)), armed=np.array([Armed.NO], np.int8))
    later = joined(ground, replace(parts, time_s=parts.time_s + 31.75))
    flown, _ = flown_part(later)
    assert flown.time_s[0] == 31.75
    assert flown.time_s[-1] == pytest.approx(31.75 + 3 * 10.0 + 2 * 0.25)

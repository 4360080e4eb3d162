"""What is said of ways that a mission flies and that were not recorded as flown."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.logs.track import Track
from flight_replay.planning.unrecorded_ways import unrecorded_notes
from tests.helpers.fit_tracks import along, circle, joined, track_through

LANE = along([(0, 0), (200, 0)], 5.0, rate_hz=5.0)


def moved(track: Track, first: int, last: int, east_m: float) -> Track:
    """The track with some of its fixes farther east."""
    places_m = track.north_east_m()
    places_m[first:last, 1] += east_m
    return track_through(places_m, track.time_s)


def test_a_recording_without_jumps_and_gaps_needs_no_words() -> None:
    """Nor one that is slow, fast, or without times."""
    for track in (LANE, circle(), along([(0, 0), (600, 0)], 20.0, rate_hz=1.0)):
        assert unrecorded_notes(track) == ()
    assert unrecorded_notes(replace(moved(LANE, 60, 70, 25.0), timed=False)) == ()


def test_jumps_that_are_flown_to_are_told() -> None:
    """A receiver's glitch of a second makes two, which a mission follows as it does all else."""
    (note,) = unrecorded_notes(moved(LANE, 60, 70, 25.0))
    told = "by 25 m at 12 s, by 25 m at 14 s."
    assert note == f"The recording jumps, faster than a vehicle flies, and the route follows: {told}"


@pytest.mark.parametrize(("seconds", "told"), [(3.0, False), (12.0, True)])
def test_gaps_are_told_from_5_s_on(seconds: float, told: bool) -> None:
    """With how far the straight way through them is."""
    there = (LANE.time_s <= 10.0) | (LANE.time_s > 10.0 + seconds)
    notes = unrecorded_notes(LANE.select(np.flatnonzero(there)))
    expected = "The vehicle flies straight on where nothing is recorded: 12 s from 10 s on (61 m)."
    assert notes == ((expected,) if told else ())


def test_rare_fixes_are_no_gaps() -> None:
    """A track with a fix every 10 s has none."""
    assert unrecorded_notes(along([(0, 0), (900, 0)], 3.0, rate_hz=0.1)) == ()


def test_the_way_between_two_flights_is_told_by_others() -> None:
    """The next flight begins elsewhere, after a while; each has its own jumps."""
    boot = replace(LANE, boot=LANE.boot + 1)
    assert unrecorded_notes(joined(LANE, boot)) == ()
    assert len(unrecorded_notes(joined(LANE, replace(moved(LANE, 60, 70, 25.0), boot=boot.boot)))) == 1

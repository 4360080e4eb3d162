"""Notes on where the vehicle does not keep to the recorded times."""

from dataclasses import replace

import numpy as np

from flight_replay.planning.fit.first_drafts.line_simplification import douglas_peucker, straight_draft
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.reference import LocalTrack, local_track
from flight_replay.planning.fit.result import fit_notes
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, sped_up, wander


def _notes(recording: LocalTrack, speed_m_s: float = np.nan) -> tuple[tuple[str, ...], bool]:
    """What is said of a recording flown along a dozen corners, at the vehicle's own speed or another."""
    line = straight_draft(recording, douglas_peucker(recording.north_east_m, 12))
    line = replace(line, speed_m_s=np.full(len(line), speed_m_s))
    problem = problem_for(recording, 12, Limits(), timed=True)
    return fit_notes(problem.evaluate(line), problem, 20)


def test_where_the_vehicle_is_behind_or_ahead_is_said() -> None:
    """A recording flown twice as fast as the vehicle can be is behind from somewhere on."""
    (late,), cannot_keep_up = _notes(local_track(sped_up(wander(3), 2.0), 20.0))
    assert "cannot keep up everywhere: it is expected to be behind by up to" in late
    assert cannot_keep_up


def test_a_vehicle_that_runs_ahead_of_a_slow_recording_is_told_of() -> None:
    """Along a straight leg at 0.05 m/s it is at the end long before the recording."""
    (early,), cannot_keep_up = _notes(local_track(along([(0, 0), (60, 0)], 0.05), 20.0))
    assert "ahead of the recording by up to" in early
    assert not cannot_keep_up


def test_too_few_waypoints_are_told() -> None:
    """Where they lead past the recording; it is then not the vehicle that does not keep up."""
    recording = local_track(wander(3), 20.0)
    few, close = (
        straight_draft(recording, douglas_peucker(recording.north_east_m, places)) for places in (4, 40)
    )
    problem = problem_for(recording, 4, Limits(), timed=True)
    (note, late, *_), cannot_keep_up = fit_notes(problem.evaluate(few), problem, 4)
    assert note.startswith("With 4 waypoints the vehicle is expected to fly")
    assert "--max-points" in note
    assert "cannot keep up" not in late
    assert not cannot_keep_up
    for draft, most in ((few, 12), (close, 40)):
        said, _ = fit_notes(problem.evaluate(draft), problem, most)
        assert not any("--max-points" in each for each in said)


def test_nothing_is_said_of_a_vehicle_that_keeps_to_the_recorded_times() -> None:
    """Along a straight leg at the recorded speed it does."""
    assert _notes(local_track(along([(0, 0), (60, 0)], 2.0), 20.0), 2.0) == ((), False)

"""Notes on where the vehicle cannot keep up."""

from flight_replay.planning.fit.first_drafts.line_simplification import douglas_peucker, straight_draft
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.reference import local_track
from flight_replay.planning.fit.result import lag_notes
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, sped_up, wander


def test_where_the_vehicle_lags_is_said() -> None:
    """A recording flown twice as fast as the vehicle can is behind from somewhere on; a slow one nowhere."""
    fast = local_track(sped_up(wander(3), 2.0), 20.0)
    slow = local_track(along([(0, 0), (60, 0)], 0.5), 20.0)
    lags = []
    for recording in (fast, slow):
        line = straight_draft(recording, douglas_peucker(recording.north_east_m, 12))
        problem = problem_for(recording, 12, Limits(), timed=True)
        lags.append(lag_notes(problem.evaluate(line), problem))
    assert len(lags[0]) == 1
    assert "behind by up to" in lags[0][0]
    assert lags[1] == ()

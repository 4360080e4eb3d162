"""The recording as a vehicle could fly it."""

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.planning.fit.first_drafts import flyable_motion as module
from flight_replay.planning.fit.first_drafts.flyable_motion import flyable_motion
from flight_replay.planning.fit.reference import LocalTrack, local_track
from tests.helpers.fit_tracks import along, track_through


def slalom(turn_s: float) -> LocalTrack:
    """Fixes three times a second for a minute, to and fro over 8 m, one way in so many seconds."""
    time_s = np.arange(180) / 3.0
    across_m = 4.0 * (1.0 - np.cos(np.pi * time_s / turn_s))
    return local_track(track_through(np.column_stack([2.0 * time_s, across_m]), time_s), 20.0)


def accelerations_m_s2(track: LocalTrack) -> np.ndarray:
    steps = np.diff(track.north_east_m, n=2, axis=0) / (track.time_s[1] - track.time_s[0]) ** 2
    return np.asarray(np.linalg.norm(steps, axis=1))


def test_what_a_vehicle_cannot_do_becomes_a_way_that_it_can_fly() -> None:
    """Turns of 10 m/s² are cut; fixes keep their times and heights."""
    recorded = slalom(2.0)
    assert accelerations_m_s2(recorded)[10:-10].max() > 8.0
    flyable = flyable_motion(recorded, 2.0)
    assert accelerations_m_s2(flyable)[1:-1].max() < 2.05
    assert (flyable.time_s == recorded.time_s).all()
    assert (flyable.up_m == recorded.up_m).all()


def test_what_a_vehicle_can_do_stays_as_it_was() -> None:
    """Turns of 0.4 m/s² are followed within centimetres, but for the ends, where the motion is at rest."""
    recorded = slalom(10.0)
    apart_m = np.linalg.norm(flyable_motion(recorded, 2.0).north_east_m - recorded.north_east_m, axis=1)
    assert apart_m[18:-18].max() < 0.08


@pytest.mark.parametrize("fixes", [2, 3, 5])
def test_a_few_fixes_are_enough(fixes: int) -> None:
    """Whatever there is has a flyable motion."""
    recorded = local_track(along([(0, 0), (20, 0)], 5.0).select(np.arange(fixes)), 20.0)
    assert np.isfinite(flyable_motion(recorded, 2.0).north_east_m).all()


def test_where_the_solver_fails_the_recording_is_what_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search then begins with waypoints on the recorded way."""

    def fails(*_: object) -> None:
        raise MissionError("no motion")

    monkeypatch.setattr(module, "nearest_motion", fails)
    recorded = slalom(2.0)
    assert flyable_motion(recorded, 2.0) is recorded

"""Routes that are followed in GUIDED, with what the flight model says of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.logs.track import Armed, Track, track_from_columns
from flight_replay.planning.following.follow_prediction import with_prediction
from flight_replay.planning.following.followed_route import FollowOptions, followed_route
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, joined


def _track(speed_m_s: float = 4.0) -> Track:
    times_s = np.arange(100.0, 160.0, 0.25)
    angle = speed_m_s / 20.0 * (times_s - 100.0)
    lat_deg = 47.0 + 20 * np.sin(angle) / 111319.0
    lon_deg = 8.0 + (20 - 20 * np.cos(angle)) / (111319.0 * np.cos(np.radians(47.0)))
    return track_from_columns(
        times_s, lat_deg, lon_deg, np.full(len(times_s), 12.0), heading_deg=np.degrees(angle) % 360
    )


def test_predicted_in_step_with_the_recording() -> None:
    track = _track()
    route = with_prediction(followed_route(track, track.alt_m, Limits(), FollowOptions()), 3.0)
    assert route.method == "guided"
    assert route.predicted is not None
    position, heading = route.predicted.position_m.statistics, route.predicted.heading_deg.statistics
    assert position is not None
    assert heading is not None
    assert position.mean < 0.2
    assert heading.mean < 3.0
    assert route.predicted_duration_s == pytest.approx(5.0 + 59.75)


def test_half_the_pace_takes_twice_as_long() -> None:
    track = _track()
    route = followed_route(track, track.alt_m, Limits(), FollowOptions(pace=0.5))
    assert route.predicted_duration_s == pytest.approx(5.0 + 119.5)
    assert route.reference is not None
    speed = np.hypot(*route.reference.velocities_m_s(np.linspace(5.0, 100.0, 200))[:, :2].T)
    assert speed.max() == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize(("speed_m_s", "next_step"), [(8.7, None), (12.0, "--speed 0.5x.")])
def test_what_cannot_be_followed_is_said_and_what_to_do(speed_m_s: float, next_step: str | None) -> None:
    track = _track(speed_m_s=speed_m_s)
    route = followed_route(track, track.alt_m, Limits(), FollowOptions())
    notes = [note for note in route.notes if "limits do not let it follow" in note]
    assert len(notes) == 1
    assert (" m off, at " in notes[0]) and ("follow slower" in notes[0]) == (next_step is not None)
    assert notes[0].endswith(next_step or " s.")


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        (Limits(), None),
        (Limits(lean_rate_rad_s=0.1), "the motion: it is predicted "),
        (Limits(guided_options=32.0), "the motion: GUID_OPTIONS 32 leaves corrections out"),
        (Limits(guided_options=16.0), "the motion: GUID_OPTIONS 16 leaves corrections out"),
    ],
    ids=["default", "slow to lean", "without corrections of the velocity", "without any of the position"],
)
def test_what_the_model_does_not_follow_is_said(limits: Limits, said: str | None) -> None:
    """Though the reference is within the vehicle's limits."""
    track = _track(speed_m_s=6.0)
    route = with_prediction(followed_route(track, track.alt_m, limits, FollowOptions()), 3.0)
    notes = [note for note in route.notes if note.startswith("The vehicle's settings do not let it keep to ")]
    assert len(notes) == (said is not None)
    assert all(said in note and note.endswith("9 m end the flight (--max-error).") for note in notes if said)


def test_a_way_far_beside_the_recording_is_not_flown() -> None:
    """A vehicle that is much too slow would cut bends, over what the recorded one flew around."""
    track = _track(speed_m_s=30.0)
    times_s = 100.0 + 10.0 * (track.time_s - 100.0)
    wide = replace(
        track,
        time_s=times_s,
        lat_deg=47.0 + 10.0 * (track.lat_deg - 47.0),
        lon_deg=8.0 + 10.0 * (track.lon_deg - 8.0),
    )
    with pytest.raises(
        MissionError, match=r"lead \d\d+ m beside it, at \d+ s; follow slower, .*--speed 0.5x"
    ):
        followed_route(wide, track.alt_m, Limits(), FollowOptions())
    route = followed_route(wide, track.alt_m, Limits(), FollowOptions(pace=0.2))
    assert route.planned_error.path_to_recorded.error.max() < 1.0


def test_the_outline_stays_above_the_floor() -> None:
    track = _track()
    route = followed_route(track, np.full(len(track), 6.0), Limits(), FollowOptions(floor_m=6.0))
    assert min(item.alt_m for _, item in route.mission.waypoints) >= 6.0 - 1e-6


def test_a_jump_is_bridged_and_said() -> None:
    track = _track()
    far = replace(track, lat_deg=track.lat_deg + np.where(track.time_s > 130.0, 0.002, 0.0))
    route = followed_route(far, far.alt_m, Limits(), FollowOptions())
    assert any("the recording jumps by 22" in note for note in route.notes)
    assert route.predicted_duration_s > 80.0


def test_flights_that_begin_far_apart_are_told_once() -> None:
    """As the jump that they are for the motion."""
    first, second = along([(0, 0), (30, 0)], 3.0), along([(130, 0), (160, 0)], 3.0)
    ground = replace(first.select(slice(0, 1)), time_s=np.array([20.0]), armed=np.array([Armed.NO], np.int8))
    track = joined(first, ground, replace(second, time_s=second.time_s + 60.0))
    route = followed_route(track, np.full(len(track), 30.0), Limits(), FollowOptions())
    assert len([note for note in route.notes if "100 m" in note]) == 1

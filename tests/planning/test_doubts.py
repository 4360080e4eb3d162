"""doubts.py: recordings that look like no multicopter's flight are told, or refused."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.logs.flights import find_flights
from flight_replay.logs.recording import Recording
from flight_replay.logs.track import Armed, Track, track_from_columns
from flight_replay.mission.items import Mission, waypoint
from flight_replay.planning.doubts import check_moves, doubts


def flown_east(speed_m_s: float, *, armed: Armed = Armed.YES) -> Track:
    """A minute on a straight line at a speed, one fix a second, at 47.4 degrees north."""
    time_s = np.arange(60.0)
    velocity = np.tile([0.0, speed_m_s, 0.0], (60, 1))
    east_deg = speed_m_s * time_s / (111_320.0 * np.cos(np.radians(47.4)))
    return track_from_columns(
        time_s,
        np.full(60, 47.4),
        8.5 + east_deg,
        np.full(60, 20.0),
        velocity_m_s=velocity,
        armed=np.full(60, armed, np.int8),
    )


def said(track: Track, **known: object) -> list[str]:
    """What is doubted of a recording of a track."""
    recording = Recording(path="made", bytes=0, track=track, **known)  # type: ignore[arg-type]
    return doubts(recording, find_flights(track), track)


def test_a_multicopters_flight_is_not_doubted() -> None:
    """At 5 m/s, armed, over 300 m there is nothing to say."""
    assert said(flown_east(5.0), vehicle_type="quadcopter", is_multicopter=True) == []


@pytest.mark.parametrize(
    ("track", "known", "words"),
    [
        (flown_east(5.0), {"vehicle_type": "submarine", "is_multicopter": False}, "log of a submarine"),
        (flown_east(20.0), {}, "moves at 20 m/s on average"),
        (
            flown_east(0.0, armed=Armed.NO),
            {},
            "No fix is armed or moves: the vehicle seems parked, within 0 m",
        ),
        (flown_east(5.0, armed=Armed.NO), {}, "tells of no armed flight, though its positions span 29"),
        (flown_east(0.1), {}, "stays within 5.9 m of one place"),
    ],
    ids=["another vehicle", "an aeroplane's speed", "parked", "never armed", "hovering"],
)
def test_what_is_no_multicopters_flight_is_said(track: Track, known: dict[str, object], words: str) -> None:
    """One sentence names what is odd."""
    sentences = said(track, **known)
    assert len(sentences) == 1
    assert words in sentences[0]


def test_waypoints_at_one_place_are_refused() -> None:
    """Two waypoints 0 m apart are no mission, unless one is above the other."""
    here, above = waypoint(47.4, 8.5, 30.0), waypoint(47.4, 8.5, 40.0)
    with pytest.raises(MissionError, match="2 waypoints are within 1 m of each other; choose another"):
        check_moves(Mission((here, here), None), flown_east(0.0), "--spacing")
    check_moves(Mission((here, above), None), flown_east(0.0), "--spacing")
    check_moves(Mission((here,), None), flown_east(0.0), "--spacing")


def test_waypoints_at_one_place_of_a_recording_that_moves_are_of_an_option() -> None:
    """Such as the first and the last fix of a flight that came back."""
    here = waypoint(47.4, 8.5, 30.0)
    with pytest.raises(MissionError, match=r"moves within .* within 1 m of each other; change --spacing"):
        check_moves(Mission((here, here), None), flown_east(5.0), "--spacing")


def test_a_flight_straight_up_is_to_be_flown_at_its_heights() -> None:
    """It moves, so that another log is no help; a height before home is set is no climb."""
    here, track = waypoint(47.4, 8.5, 30.0), flown_east(0.0)
    mission = Mission((here, here), None)
    up_m = np.linspace(0.0, 40.0, len(track))
    with pytest.raises(MissionError, match=r"moves up and down, by 40 m, .* with --altitude recorded"):
        check_moves(mission, replace(track, alt_m=up_m, amsl_m=up_m + 488.0), "--spacing")
    parked_m = np.append(488.0, np.zeros(len(track) - 1))
    with pytest.raises(MissionError, match="the recording does not move"):
        check_moves(mission, replace(track, alt_m=parked_m, amsl_m=np.full(len(track), 488.0)), "--spacing")
    with pytest.raises(MissionError, match="the recording does not move"):
        check_moves(mission, replace(track, alt_m=np.full(len(track), np.nan)), "--spacing")

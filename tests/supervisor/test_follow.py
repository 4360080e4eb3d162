"""Flights that follow a recording in GUIDED, on a scripted vehicle and a virtual clock."""

from __future__ import annotations

import re

import numpy as np
import pytest

from flight_replay.events import Following, Notice, PassFlown, Phase, PhaseStarted, ReturnCommanded
from flight_replay.exceptions import PhaseTimeoutError, VehicleError
from flight_replay.supervisor.vehicle_interface import Heartbeat
from tests.helpers.fake_vehicle import FRAME, FakeClock, FakeVehicle
from tests.helpers.supervised import RECORDED_S, FakeFlight, fake_following, s_curve


def _vehicle(**rules: object) -> FakeVehicle:
    return FakeVehicle(FakeClock(), **rules)  # type: ignore[arg-type]


def _error_m(flight: FakeFlight, time_s: float) -> float:
    """How far the vehicle's latest target before a vehicle time is from the reference at that time."""
    at_s, target = [each for each in flight.vehicle.targets if each[0] <= time_s][-1]
    place_m = FRAME.to_metres(target.lat_deg, target.lon_deg)
    began_s = flight.vehicle.targets[0][0] + 5.0
    return float(np.linalg.norm(place_m - s_curve().state(at_s - began_s).position_m[:2]))


@pytest.mark.parametrize("speedup", [1.0, 10.0])
def test_follows_the_whole_recording_in_step_then_returns(speedup: float) -> None:
    flight = fake_following(_vehicle(speedup=speedup), duration_s=None)
    record = flight.fly()
    assert (record.ended, record.problem, record.rtl_confirmed) == ("recording complete", None, True)
    assert "AUTO" not in flight.vehicle.requested
    assert "verify" not in flight.vehicle.requested
    assert record.recording_s is not None
    assert record.recording_s[-1] == pytest.approx(RECORDED_S, abs=1.5)
    assert record.auto_s == pytest.approx(RECORDED_S + 5.0, abs=1.5)
    assert _error_m(flight, record.auto_start_s + 30.0) < 0.3 * max(1.0, speedup / 5)
    phases = [event.phase for event in flight.of(PhaseStarted)]
    assert phases[-3:] == [Phase.APPROACH, Phase.FOLLOW, Phase.RETURN]


def test_a_duration_is_the_recordings_time() -> None:
    record = fake_following(duration_s=10.0).fly()
    assert record.ended == "duration"
    assert record.auto_s == pytest.approx(15.0, abs=0.5)


def test_targets_come_ten_times_a_second_of_the_vehicles_clock() -> None:
    flight = fake_following(duration_s=20.0)
    flight.fly()
    steps_s = np.diff([time_s for time_s, _ in flight.vehicle.targets])
    assert np.median(steps_s) == pytest.approx(0.1, abs=0.02)
    assert steps_s.max() < 0.25


def test_a_pilot_who_takes_over_ends_the_stream_for_good() -> None:
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=None)
    taken_s: list[float] = []

    def take_over() -> None:
        vehicle.mode = "LOITER"
        taken_s.append(vehicle.time_s)

    vehicle.schedule.append((50.0, take_over))
    record = flight.fly()
    assert record.ended == "pilot"
    assert vehicle.requested[-1] != "RTL"
    assert not flight.of(ReturnCommanded)
    assert vehicle.targets[-1][0] <= taken_s[0] + 1.2  # Until the next heartbeat tells.


def test_a_vehicle_that_is_back_in_guided_by_itself_is_left_alone() -> None:
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=None)
    modes = iter(("LOITER", "GUIDED"))

    def change() -> None:
        vehicle.mode = next(modes)

    vehicle.schedule += [(50.0, change), (51.1, change)]
    record = flight.fly()
    assert record.ended == "pilot"
    assert "RTL" not in vehicle.requested


def test_a_heartbeat_of_another_mode_that_is_the_last_one_ends_the_flight() -> None:
    """Positions still come, but nothing confirms the mode: whoever changed it has the vehicle."""
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=None)

    def last_heartbeat() -> None:
        vehicle.queue.append(Heartbeat("LOITER", True))
        vehicle.heartbeat_s = float("inf")

    vehicle.schedule.append((50.0, last_heartbeat))
    record = flight.fly()
    assert record.ended == "pilot"
    assert flight.wall_s < 75.0


def test_the_reference_waits_for_a_vehicle_that_does_not_follow() -> None:
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=None)

    def follow(follows: bool) -> None:
        vehicle.follows = follows

    vehicle.schedule += [(52.0, lambda: follow(False)), (57.0, lambda: follow(True))]
    record = flight.fly()
    assert record.ended == "recording complete"
    assert any(event.waiting for event in flight.of(Following))
    assert record.auto_s > RECORDED_S + 6.0


def _move(vehicle: FakeVehicle, *, east_m: float = 0.0, up_m: float = 0.0) -> None:
    vehicle.follows = False
    vehicle.place_m = vehicle.place_m + np.array([0.0, east_m])
    vehicle.altitude_m += up_m


@pytest.mark.parametrize(
    ("step", "words"),
    [
        ({"east_m": 1.5}, "m from where it was to be; check wind, .*--max-error"),
        ({"up_m": -1.5}, "m below where it was to be; check its motors"),
        ({"up_m": 1.5}, "m above where it was to be; check its barometer"),
    ],
    ids=["blown away", "falling", "rising"],
)
def test_a_vehicle_far_off_course_is_sent_home(step: dict[str, float], words: str) -> None:
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=None)
    vehicle.schedule += [(50.0 + 0.1 * i, lambda: _move(vehicle, **step)) for i in range(20)]
    record = flight.fly()
    assert record.ended == "off course"
    assert record.rtl_confirmed
    assert re.search(words, str(record.problem))
    assert not any("jumped" in notice.text for notice in flight.of(Notice))


def test_a_jump_of_the_position_is_told_and_named_as_what_led_off_course() -> None:
    """Wind and load did not move the vehicle there."""
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=None)
    vehicle.schedule.append((50.0, lambda: _move(vehicle, east_m=30.0)))
    record = flight.fly()
    assert (record.ended, record.rtl_confirmed) == ("off course", True)
    assert "position estimate jumped by 30 m, and it was" in str(record.problem)
    assert "check its GPS" in str(record.problem)
    assert "wind" not in str(record.problem)
    assert "jumped by 30 m" in flight.of(Notice)[0].text


def test_a_silent_vehicle_gets_no_targets_and_rejoins_where_it_is() -> None:
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=None)
    silent_s: list[float] = []

    def silence(silent: bool) -> None:
        vehicle.silent = silent
        silent_s.append(vehicle.time_s)

    vehicle.schedule += [(50.0, lambda: silence(True)), (58.0, lambda: silence(False))]
    record = flight.fly()
    assert record.ended == "recording complete"
    between = [time_s for time_s, _ in vehicle.targets if silent_s[0] + 1.2 < time_s < silent_s[1]]
    assert not between
    places = np.array([FRAME.to_metres(t.lat_deg, t.lon_deg) for _, t in vehicle.targets])
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 1.0


def test_a_vehicle_that_does_not_get_to_the_beginning_is_sent_home() -> None:
    vehicle = _vehicle()
    vehicle.request_position = lambda *_: None  # type: ignore[method-assign]
    flight = fake_following(vehicle)
    with pytest.raises(PhaseTimeoutError, match="m from where the recording begins"):
        flight.fly()
    assert vehicle.requested[-1] == "RTL"


def test_a_vehicle_that_falls_on_the_way_to_the_beginning_is_told_soon() -> None:
    """Not after a minute as one that stopped."""
    vehicle = _vehicle()
    vehicle.request_position = lambda *_: None  # type: ignore[method-assign]
    vehicle.schedule.append((20.0, lambda: setattr(vehicle, "target_m", 0.0)))
    flight = fake_following(vehicle)
    with pytest.raises(VehicleError, match=r"has fallen: it is 0\.0 m above home, and was to be at 30 m"):
        flight.fly()
    assert vehicle.requested[-1] == "RTL"
    assert flight.wall_s < 30.0


def test_a_vehicle_that_does_not_tell_its_local_position_is_not_followed() -> None:
    vehicle = _vehicle(local_position=False)
    with pytest.raises(PhaseTimeoutError, match="LOCAL_POSITION_NED"):
        fake_following(vehicle).fly()
    assert vehicle.requested[-1] == "RTL"


def test_a_pilot_on_the_way_to_the_beginning_is_not_overruled() -> None:
    vehicle = _vehicle()

    def take_over() -> None:
        vehicle.mode = "LOITER"

    vehicle.schedule.append((20.0, take_over))
    with pytest.raises(VehicleError, match="LOITER"):
        fake_following(vehicle).fly()
    assert "RTL" not in vehicle.requested


def test_a_pilot_who_was_there_on_the_way_to_the_beginning_has_the_vehicle() -> None:
    vehicle = _vehicle()
    modes = iter(("LOITER", "GUIDED"))

    def change() -> None:
        vehicle.mode = next(modes)

    vehicle.schedule += [(20.0, change), (21.1, change)]
    with pytest.raises(VehicleError, match="LOITER"):
        fake_following(vehicle).fly()
    assert vehicle.requested[-1] == "position"
    assert "RTL" not in vehicle.requested


@pytest.mark.parametrize("begin_s", [20.0, 50.0], ids=["approach", "following"])
def test_a_vehicle_that_disarms_ends_the_flight_at_once(begin_s: float) -> None:
    vehicle = _vehicle()
    vehicle.schedule.append((begin_s, lambda: setattr(vehicle, "armed", False)))
    flight = fake_following(vehicle, duration_s=None)
    problem = _problem(flight)
    assert "disarmed in flight" in problem
    assert flight.wall_s < begin_s + 5.0


def _problem(flight: FakeFlight) -> str:
    try:
        return flight.fly().problem or ""
    except VehicleError as error:
        return str(error)


def test_a_vehicle_that_drifts_away_is_sent_home() -> None:
    """Slowly, as in a storm: its targets are near it, but the reference is not."""
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=None)

    def drift() -> None:
        vehicle.follows = False
        vehicle.place_m = vehicle.place_m + np.array([0.0, 0.3])
        vehicle.schedule.insert(0, (vehicle.clock.now_s - vehicle.began_s + 0.1, drift))

    vehicle.schedule.append((50.0, drift))
    record = flight.fly()
    assert record.ended == "off course"
    assert record.rtl_confirmed


def test_a_vehicle_that_falls_is_told_to_have_disarmed() -> None:
    """It is far from its target before a heartbeat says so."""
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=None, land=True)

    def fall() -> None:
        vehicle.follows, vehicle.armed = False, False
        vehicle.heartbeat_s = vehicle.time_s
        vehicle.altitude_m -= 12.0

    vehicle.schedule.append((50.05, fall))
    record = flight.fly()
    assert record.ended == "disarmed"
    assert record.problem == "the vehicle disarmed in flight; find out why before flying again"


def test_a_vehicle_that_stays_armed_on_the_ground_is_told_first() -> None:
    """What has to be watched now comes before what led there."""
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=None, land=True)

    def crash() -> None:
        vehicle.follows = False
        vehicle.place_m, vehicle.altitude_m = vehicle.place_m + np.array([0.0, 30.0]), 0.0
        vehicle.move = lambda step_s: None  # type: ignore[method-assign]

    vehicle.schedule.append((50.0, crash))
    record = flight.fly()
    assert (record.ended, record.landed) == ("off course", False)
    assert record.problem is not None
    assert record.problem.startswith(
        "the vehicle stays where it fell, and has not disarmed in LAND: keep away, and disarm it on the "
    )
    assert "before that the vehicle's position estimate jumped by 30 m" in record.problem


def test_the_way_to_the_beginning_is_flown_at_the_asked_speed() -> None:
    flight = fake_following(approach_m_s=3.0, speed_m_s=8.0, duration_s=1.0)
    flight.fly()
    speeds = [each for each in flight.vehicle.requested if each.startswith("speed")]
    assert speeds[0] == "speed 3"
    assert speeds[-1] == "speed 8"


def test_passes_are_flown_one_after_the_other_and_the_last_is_recorded() -> None:
    """Between them the vehicle flies back to the beginning."""
    flight = fake_following(duration_s=20.0, passes=3)
    record = flight.fly()
    assert (record.ended, record.problem, record.rtl_confirmed) == ("duration", None, True)
    assert record.auto_s == pytest.approx(25.0, abs=1.0)
    assert record.recording_s is not None
    assert record.recording_s[-1] == pytest.approx(20.0, abs=1.0)
    phases = [event.phase for event in flight.of(PhaseStarted)]
    assert phases[-7:] == [Phase.APPROACH, Phase.FOLLOW] * 3 + [Phase.RETURN]
    passes = flight.of(PassFlown)
    assert [(each.number, each.passes) for each in passes] == [(1, 3), (2, 3)]
    assert all(0.0 <= each.off_m < 1.0 for each in passes)


def test_a_pilot_who_takes_over_in_an_early_pass_has_the_vehicle() -> None:
    """The flight ends; nothing is commanded, and no other pass begins."""
    vehicle = _vehicle()
    flight = fake_following(vehicle, duration_s=35.0, passes=2)
    vehicle.schedule.append((50.0, lambda: setattr(vehicle, "mode", "LOITER")))
    with pytest.raises(VehicleError, match="LOITER"):
        flight.fly()
    assert "RTL" not in vehicle.requested
    assert not flight.of(ReturnCommanded)


def test_a_followed_recording_ends_where_no_position_is_told() -> None:
    """The vehicle stands still without targets, and is sent home."""
    vehicle = _vehicle()
    vehicle.schedule.append((50.0, lambda: setattr(vehicle, "reports_clock", False)))
    record = fake_following(vehicle, duration_s=None).fly()
    assert (record.ended, record.rtl_confirmed) == ("no progress", True)
    assert "has told no position for 10 s" in (record.problem or "")

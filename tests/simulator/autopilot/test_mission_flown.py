"""AUTO: missions flown item by item; in vehicle time."""

from __future__ import annotations

import math

import pytest

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from flight_replay.mission.items import speed_from_the_start
from tests.helpers.sim_station import (
    ACCEPTED,
    AUTO,
    FAILED,
    LOITER,
    Item,
    act,
    item_at,
    sim,
)

SQUARE = [item_at(40, 0), item_at(40, 40), item_at(0, 40)]


def test_a_mission_is_flown_item_by_item() -> None:
    """Each item is announced, reached and counted; after the last the copter stays, still in AUTO."""
    autopilot, station = sim()
    station.fly()
    station.upload(SQUARE)
    assert station.mode(AUTO) == ACCEPTED
    assert station.run(120, lambda: 3 in station.reached())
    assert station.reached() == [1, 2, 3]
    for text in ("Mission: 1 WP", "Reached command #1", "Mission: 3 WP", "Reached command #3"):
        assert text in station.texts
    station.run(5)
    station.channel.request(dialect.MAVLINK_MSG_ID_MISSION_CURRENT)
    current = station.last("MISSION_CURRENT")
    assert (current.seq, current.total, current.mission_state, current.mission_mode) == (3, 3, 5, 1)
    assert autopilot.mode == CopterMode.AUTO
    north_m, east_m, up_m = autopilot.flight.position_m
    assert math.dist((north_m, east_m, up_m), (0, 40, 20)) < 1


@pytest.mark.parametrize(("speed_cm_s", "flown_m_s"), [(500, 5.0), (1000, 2.0)])
def test_the_first_mission_may_not_heed_its_first_speed(speed_cm_s: float, flown_m_s: float) -> None:
    """After a start, where WPNAV_SPEED is not the compiled default, as of 4.6; the next mission does."""
    autopilot, station = sim(WPNAV_SPEED=speed_cm_s, MIS_RESTART=1)
    station.fly()
    station.upload([act(178, 1, 2, -1), item_at(160, 0)])
    for fastest_m_s in (flown_m_s, 2.0):
        assert station.mode(AUTO) == ACCEPTED
        station.run(12)
        assert math.hypot(*autopilot.flight.velocity_m_s) == pytest.approx(fastest_m_s, abs=0.1)
        station.mode(LOITER)
        station.run(5)


def test_a_speed_from_the_start_is_heeded() -> None:
    """A second's wait here, and the speed change holds from the first leg on."""
    autopilot, station = sim(WPNAV_SPEED=500)
    station.fly()
    wait, change = speed_from_the_start(2.0)
    here = int(wait.command), int(wait.frame), wait.params, 0, 0, wait.alt_m
    station.upload([here, act(change.command, *change.params), item_at(160, 0)])
    assert station.mode(AUTO) == ACCEPTED
    speeds_m_s, heights_m = [], []
    for _ in range(15):
        station.run(1)
        speeds_m_s.append(math.hypot(*autopilot.flight.velocity_m_s))
        heights_m.append(autopilot.flight.position_m[2])
    assert speeds_m_s[-1] == pytest.approx(2.0, abs=0.1)
    assert max(speeds_m_s) < 2.2
    assert min(heights_m) > 19.0


def test_do_items_take_the_place_of_the_item_before_in_the_report() -> None:
    """A DO item that is done at once hides the item before it; those that wait are reported each."""
    _, station = sim()
    station.fly()
    station.upload([item_at(30, 0), act(178, 1, 3, -1), act(112, 1), act(178, 1, 4, -1), item_at(30, 30)])
    station.mode(AUTO)
    assert station.run(120, lambda: 5 in station.reached())
    assert station.reached() == [2, 3, 4, 5]
    assert station.texts.index("Mission: 2 ChangeSpeed") < station.texts.index("Mission: 5 WP")


def test_jumps_are_flown_as_often_as_they_say() -> None:
    """DO_JUMP back to 1 twice: the items before it are flown three times."""
    _, station = sim()
    station.fly()
    station.upload([item_at(10, 0), item_at(0, 0), act(177, 1, 2), item_at(0, 10)])
    station.mode(AUTO)
    assert station.order_of(4) == [*["1 WP", "2 WP"] * 3, "4 WP"]


def test_jumps_can_go_on_for_ever_and_lead_nowhere() -> None:
    """-1 repeats without end; a jump onto itself is passed over, as is one that never jumps."""
    autopilot, station = sim()
    station.fly()
    station.upload([item_at(10, 0), act(177, 2, -1), item_at(0, 10)])
    station.mode(AUTO)
    station.run(30)
    assert autopilot.mission.seq == 1
    station.mode(LOITER)
    station.upload([item_at(10, 0), item_at(0, 0), act(177, 1, -1)])
    station.mode(AUTO)
    station.run(120)
    assert autopilot.mode.value == AUTO
    assert station.reached().count(1) > 3


@pytest.mark.parametrize(
    ("item", "seconds"),
    [(item_at(0, 0, 20, command=19, hold_s=7), 7), ((93, 2, (9.0, -1.0, -1.0, -1.0), 0, 0, 0.0), 9)],
    ids=["loiter time", "delay"],
)
def test_items_that_wait_wait(item: Item, seconds: float) -> None:
    """NAV_LOITER_TIME and NAV_DELAY hold the vehicle for their seconds."""
    autopilot, station = sim()
    station.fly()
    station.run(10)
    station.upload([item, item_at(0, 30)])
    station.mode(AUTO)
    began_s = autopilot.time_s
    assert station.run(60, lambda: autopilot.mission.seq == 2)
    assert autopilot.time_s - began_s == pytest.approx(seconds, abs=2.5)


def test_a_loiter_without_end_is_left_by_a_station_only() -> None:
    """NAV_LOITER_UNLIM stays until another mode or item is chosen."""
    autopilot, station = sim()
    station.fly()
    station.upload([item_at(20, 0, command=17), item_at(0, 0)])
    station.mode(AUTO)
    station.run(120)
    assert autopilot.mission.seq == 1
    assert math.dist(autopilot.flight.position_m, (20, 0, 20)) < 1
    assert station.command(224, 2) == ACCEPTED
    assert station.run(60, lambda: 2 in station.reached())


def test_a_land_item_lands_there_and_ends_the_mission() -> None:
    """NAV_LAND with a location flies there, lands and disarms."""
    autopilot, station = sim()
    station.fly(10)
    station.upload([item_at(10, 0, 10), item_at(20, 5, 0, command=21)])
    station.mode(AUTO)
    assert station.run(120, lambda: not autopilot.armed)
    assert math.dist(autopilot.flight.position_m, (20, 5, 0)) < 1


def test_wind_is_felt_and_told() -> None:
    """SIM_WIND_* leans the copter against the wind at once, and WIND says where it comes from.

    By default it grows with the root of the height up to SIM_WIND_T_ALT.
    """
    autopilot, station = sim(SIM_WIND_T_ALT=80)
    station.fly()
    autopilot.parameters.assign("SIM_WIND_DIR", 0)
    autopilot.parameters.assign("SIM_WIND_SPD", 8)
    station.run(20)
    assert math.dist(autopilot.flight.position_m, (0, 0, 20)) < 2
    roll, pitch, yaw = autopilot.flight.attitude_rad
    assert math.degrees(roll * math.sin(yaw) + pitch * math.cos(yaw)) < -3
    station.channel.request(dialect.MAVLINK_MSG_ID_WIND)
    wind = station.last("WIND")
    assert (wind.direction, wind.speed) == pytest.approx((0, 4), abs=0.1)
    for profile, speed_m_s in ((1, 8.0), (2, 8.0 - 0.01 * 60)):
        autopilot.parameters.assign("SIM_WIND_T", profile)
        station.channel.request(dialect.MAVLINK_MSG_ID_WIND)
        assert station.last("WIND").speed == pytest.approx(speed_m_s, abs=0.05)


def test_items_that_arducopter_cannot_fly_are_passed_over() -> None:
    """Commands that it stores and does not start are spoken of, stopped before, and not reached."""
    _, station = sim()
    station.fly()
    station.upload(
        [item_at(20, 0), act(183, 5, 1500), item_at(20, 5, command=30), act(178, 1, 1), item_at(0, 0)]
    )
    station.mode(AUTO)
    assert station.order_of(5) == ["1 WP", "2 SetServo", "3 ContinueAndChangeAlt", "5 WP"]
    assert station.reached() == [1, 5]


@pytest.mark.parametrize(
    ("item", "text"),
    [
        (item_at(20, 5, command=31), "Auto: 2 LoitAltitude is not simulated"),
        (item_at(20, 5, command=94), "Auto: 2 PayloadPlace is not simulated"),
        (act(93, 0, 12, 30), "Auto: 2 Delay is not simulated"),
        (act(601, 3, 1), "Auto: 2 JumpToTag is not simulated"),
    ],
    ids=["loiter to altitude", "payload place", "delay to a time of day", "jump to a tag"],
)
def test_what_is_not_simulated_is_refused_by_name(item: Item, text: str) -> None:
    """AUTO is not entered with an item that ArduCopter would fly and the model does not."""
    autopilot, station = sim()
    station.fly()
    station.upload([item_at(20, 0), item, item_at(0, 0)])
    assert station.mode(AUTO) == FAILED
    assert text in station.texts
    assert autopilot.mode == CopterMode.GUIDED

"""AUTO: missions flown, left, resumed and changed; in vehicle time."""

from __future__ import annotations

import math

import pytest
from sim_station import (
    ARM,
    AUTO,
    GUIDED,
    LOITER,
    MISSION_START,
    READY_S,
    Item,
    Station,
    act,
    place,
    sim,
    takeoff,
)

from flight_replay.simulator.mavlink import dialect
from flight_replay.simulator.modes import Mode

ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4


SQUARE = [place(40, 0), place(40, 40), place(0, 40)]


def reached(station: Station) -> list[int]:
    """Items reported as reached."""
    return [message.seq for message in station.of("MISSION_ITEM_REACHED")]


def test_auto_from_the_ground_needs_a_takeoff_item() -> None:
    """Armed on the ground, a mission without a take-off is refused with ArduCopter's words."""
    _, station = sim()
    station.run(READY_S)
    station.upload(SQUARE)
    station.mode(GUIDED)
    station.command(ARM, 1)
    assert station.mode(AUTO) == FAILED
    assert "Auto: Missing Takeoff Cmd" in station.texts
    assert station.texts[-1] == "Mode change to AUTO failed: init failed"


def test_auto_in_the_air_needs_a_mission() -> None:
    """Without items, AUTO is refused in flight."""
    autopilot, station = sim()
    station.fly()
    assert station.mode(AUTO) == FAILED
    assert autopilot.mode == Mode.GUIDED


def test_a_mission_is_flown_item_by_item() -> None:
    """Each item is announced, reached and counted; after the last the copter stays, still in AUTO."""
    autopilot, station = sim()
    station.fly()
    station.upload(SQUARE)
    assert station.mode(AUTO) == ACCEPTED
    assert station.run(120, lambda: 3 in reached(station))
    assert reached(station) == [1, 2, 3]
    for text in ("Mission: 1 WP", "Reached command #1", "Mission: 3 WP", "Reached command #3"):
        assert text in station.texts
    station.run(5)
    station.channel.request(dialect.MAVLINK_MSG_ID_MISSION_CURRENT)
    current = station.last("MISSION_CURRENT")
    assert (current.seq, current.total, current.mission_state, current.mission_mode) == (3, 3, 5, 1)
    assert autopilot.mode == Mode.AUTO
    north_m, east_m, up_m = autopilot.flight.position_m
    assert math.dist((north_m, east_m, up_m), (0, 40, 20)) < 1


def test_do_items_take_the_place_of_the_item_before_in_the_report() -> None:
    """A DO item is done at once, and of one instant only the last item is reported, as ArduCopter does."""
    _, station = sim()
    station.fly()
    station.upload([place(30, 0), act(178, 1, 3, -1), place(30, 30)])
    station.mode(AUTO)
    assert station.run(120, lambda: 3 in reached(station))
    assert reached(station) == [2, 3]
    assert station.texts.index("Mission: 2 ChangeSpeed") < station.texts.index("Mission: 3 WP")


def test_a_whole_mission_from_takeoff_to_landing() -> None:
    """MISSION_START lifts off by itself; RTL as an item lands and disarms, and the mission is reset."""
    autopilot, station = sim(AUTO_OPTIONS=1)
    station.run(READY_S)
    station.upload([takeoff(15), place(30, 0), act(20)])
    station.mode(AUTO)
    assert station.command(ARM, 1) == ACCEPTED
    station.run(3)
    assert autopilot.flight.landed
    assert station.command(MISSION_START) == ACCEPTED
    assert station.run(200, lambda: not autopilot.armed)
    assert {1, 2} <= set(reached(station))
    assert math.dist(autopilot.flight.position_m, (0, 0, 0)) < 0.5
    assert autopilot.mission.seq == 0


def test_a_mission_goes_on_where_it_was_left() -> None:
    """MIS_RESTART 0 resumes, 1 begins anew."""
    autopilot, station = sim()
    station.fly()
    station.upload(SQUARE)
    station.mode(AUTO)
    station.run(60, lambda: autopilot.mission.seq == 2)
    station.mode(LOITER)
    station.run(3)
    station.mode(AUTO)
    station.run(1)
    assert autopilot.mission.seq == 2
    autopilot.parameters.assign("MIS_RESTART", 1)
    station.mode(LOITER)
    station.mode(AUTO)
    station.run(1)
    assert autopilot.mission.seq == 1


def test_a_station_chooses_the_current_item() -> None:
    """MISSION_SET_CURRENT and DO_SET_MISSION_CURRENT jump, before and during the flight."""
    autopilot, station = sim()
    station.fly()
    station.upload(SQUARE)
    station.send(dialect.MAVLink_mission_set_current_message(1, 1, 2))
    assert station.last("MISSION_CURRENT").seq == 2
    station.mode(AUTO)
    station.run(1)
    assert autopilot.mission.seq == 2
    assert station.command(224, 3) == ACCEPTED
    station.run(1)
    assert autopilot.mission.seq == 3
    assert station.command(224, 9) == DENIED


def test_a_running_mission_is_not_cleared() -> None:
    """MISSION_CLEAR_ALL fails while the mission is flown, and works otherwise."""
    autopilot, station = sim()
    station.fly()
    station.upload(SQUARE)
    station.mode(AUTO)
    station.run(1)
    station.send(dialect.MAVLink_mission_clear_all_message(1, 1))
    assert station.last("MISSION_ACK").type == dialect.MAV_MISSION_ERROR
    station.mode(LOITER)
    station.send(dialect.MAVLink_mission_clear_all_message(1, 1))
    assert station.last("MISSION_ACK").type == dialect.MAV_MISSION_ACCEPTED
    assert len(autopilot.store) == 0


def test_a_mission_changed_in_flight_is_flown_as_changed() -> None:
    """New items near the current one restart its leg, with a text; farther ones are just flown later."""
    autopilot, station = sim()
    station.fly()
    station.upload([*SQUARE, place(0, 0), place(-40, 0)])
    station.mode(AUTO)
    station.run(1)
    for seq, moved, restarts in ((5, place(-20, 0), False), (1, place(25, 0), True)):
        station.forget()
        station.send(dialect.MAVLink_mission_write_partial_list_message(1, 1, seq, seq))
        command, frame, params, x, y, z = moved
        station.send(
            dialect.MAVLink_mission_item_int_message(1, 1, seq, frame, command, 0, 1, *params, x, y, z)
        )
        station.run(1)
        assert ("Auto mission changed, restarted command" in station.texts) == restarts
    assert station.run(200, lambda: 5 in reached(station))
    assert math.dist(autopilot.flight.position_m, (-20, 0, 20)) < 3


def order_of(station: Station, count: int) -> list[str]:
    """The items begun, as spoken."""
    station.run(300, lambda: f"Reached command #{count}" in station.texts)
    return [text.removeprefix("Mission: ") for text in station.texts if text.startswith("Mission: ")]


def test_jumps_are_flown_as_often_as_they_say() -> None:
    """DO_JUMP back to 1 twice: the items before it are flown three times."""
    _, station = sim()
    station.fly()
    station.upload([place(10, 0), place(0, 0), act(177, 1, 2), place(0, 10)])
    station.mode(AUTO)
    assert order_of(station, 4) == [*["1 WP", "2 WP"] * 3, "4 WP"]


def test_jumps_can_go_on_for_ever_and_lead_nowhere() -> None:
    """-1 repeats without end; a jump onto itself is passed over, as is one that never jumps."""
    autopilot, station = sim()
    station.fly()
    station.upload([place(10, 0), act(177, 2, -1), place(0, 10)])
    station.mode(AUTO)
    station.run(30)
    assert autopilot.mission.seq == 1
    station.mode(LOITER)
    station.upload([place(10, 0), place(0, 0), act(177, 1, -1)])
    station.mode(AUTO)
    station.run(120)
    assert autopilot.mode.value == AUTO
    assert reached(station).count(1) > 3


@pytest.mark.parametrize(
    ("item", "seconds"),
    [(place(0, 0, 20, command=19, hold_s=7), 7), ((93, 2, (9.0, -1.0, -1.0, -1.0), 0, 0, 0.0), 9)],
    ids=["loiter time", "delay"],
)
def test_items_that_wait_wait(item: Item, seconds: float) -> None:
    """NAV_LOITER_TIME and NAV_DELAY hold the vehicle for their seconds."""
    autopilot, station = sim()
    station.fly()
    station.run(10)
    station.upload([item, place(0, 30)])
    station.mode(AUTO)
    began_s = autopilot.time_s
    assert station.run(60, lambda: autopilot.mission.seq == 2)
    assert autopilot.time_s - began_s == pytest.approx(seconds, abs=2.5)


def test_a_loiter_without_end_is_left_by_a_station_only() -> None:
    """NAV_LOITER_UNLIM stays until another mode or item is chosen."""
    autopilot, station = sim()
    station.fly()
    station.upload([place(20, 0, command=17), place(0, 0)])
    station.mode(AUTO)
    station.run(120)
    assert autopilot.mission.seq == 1
    assert math.dist(autopilot.flight.position_m, (20, 0, 20)) < 1
    assert station.command(224, 2) == ACCEPTED
    assert station.run(60, lambda: 2 in reached(station))


def test_a_land_item_lands_there_and_ends_the_mission() -> None:
    """NAV_LAND with a place flies there, lands and disarms."""
    autopilot, station = sim()
    station.fly(10)
    station.upload([place(10, 0, 10), place(20, 5, 0, command=21)])
    station.mode(AUTO)
    assert station.run(120, lambda: not autopilot.armed)
    assert math.dist(autopilot.flight.position_m, (20, 5, 0)) < 1


def test_wind_is_felt_and_told() -> None:
    """SIM_WIND_* leans the copter against the wind at once, and WIND says where it comes from."""
    autopilot, station = sim()
    station.fly()
    autopilot.parameters.assign("SIM_WIND_DIR", 0)
    autopilot.parameters.assign("SIM_WIND_SPD", 8)
    station.run(20)
    assert math.dist(autopilot.flight.position_m, (0, 0, 20)) < 2
    roll, pitch, yaw = autopilot.flight.attitude_rad
    assert math.degrees(roll * math.sin(yaw) + pitch * math.cos(yaw)) < -3
    station.channel.request(dialect.MAVLINK_MSG_ID_WIND)
    wind = station.last("WIND")
    assert (wind.direction, wind.speed) == pytest.approx((0, 8), abs=0.01)

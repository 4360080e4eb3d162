"""AUTO: missions left, resumed, chosen from and changed; in vehicle time."""

from __future__ import annotations

import math

import pytest

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from tests.helpers.sim_station import (
    ACCEPTED,
    ARM,
    AUTO,
    DENIED,
    FAILED,
    GUIDED,
    LOITER,
    MISSION_START,
    READY_S,
    act,
    item_at,
    sim,
    takeoff,
)

SQUARE = [item_at(40, 0), item_at(40, 40), item_at(0, 40)]


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


def test_auto_needs_a_mission() -> None:
    """Armed and without items, AUTO is refused on the ground and in flight; no take-off is asked for."""
    autopilot, station = sim()
    station.run(READY_S)
    station.mode(GUIDED)
    station.command(ARM, 1)
    assert station.mode(AUTO) == FAILED
    assert "Auto: Missing Takeoff Cmd" not in station.texts
    station.fly()
    assert station.mode(AUTO) == FAILED
    assert autopilot.mode == CopterMode.GUIDED


def test_a_whole_mission_from_takeoff_to_landing() -> None:
    """AUTO begins on the ground, MISSION_START lifts off; RTL lands and disarms, and that completes it."""
    autopilot, station = sim(AUTO_OPTIONS=1)
    station.run(READY_S)
    station.upload([takeoff(15), item_at(30, 0), act(20)])
    station.mode(AUTO)
    assert station.command(ARM, 1) == ACCEPTED
    station.run(3)
    assert "Mission: 1 Takeoff" in station.texts
    assert autopilot.mission.seq == 1
    assert autopilot.flight.landed
    assert station.command(MISSION_START) == ACCEPTED
    assert station.run(200, lambda: not autopilot.armed)
    assert station.reached() == [1, 2, 3]
    assert math.dist(autopilot.flight.position_m, (0, 0, 0)) < 0.5
    assert station.texts.count("Mission: 1 Takeoff") == 1
    station.run(1)
    assert station.texts.count("Mission: 1 Takeoff") == 1
    assert (autopilot.mission.state, autopilot.mission.seq) == (dialect.MISSION_STATE_COMPLETE, 0)


def test_a_mission_that_ends_with_a_landing_begins_anew() -> None:
    """Disarming ends LAND before the mission knows that it is done, and AUTO is still on."""
    autopilot, station = sim()
    station.fly()
    station.upload([item_at(10, 0), act(21)])
    station.mode(AUTO)
    assert station.run(200, lambda: not autopilot.armed)
    station.run(1)
    assert station.texts.count("Mission: 1 WP") == 2
    assert (autopilot.mission.state, autopilot.mission.seq) == (dialect.MISSION_STATE_ACTIVE, 1)


def test_a_complete_mission_is_started_again() -> None:
    """MISSION_START flies it from its first item, in AUTO and from GUIDED, as often as it comes."""
    autopilot, station = sim()
    station.fly()
    station.upload([act(178, 1, 5, -1), item_at(10, 0), item_at(20, 0)])
    for times, mode in enumerate((AUTO, AUTO, GUIDED), 1):
        station.mode(mode)
        assert station.command(MISSION_START) == ACCEPTED
        station.run(0.1)
        assert station.run(60, lambda: autopilot.mission.state == dialect.MISSION_STATE_COMPLETE)
        station.run(3)
        assert station.reached() == [1, 2, 3] * times


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


def test_what_is_done_on_the_way_to_a_chosen_item_is_done() -> None:
    """DO items before the first waypoint are run where a station set the mission to its beginning."""
    autopilot, station = sim()
    station.fly()
    station.upload([act(178, 1, 2.0), act(115, 90), *SQUARE])
    station.send(dialect.MAVLink_mission_set_current_message(1, 1, 0))
    assert autopilot.mission.seq == 3
    station.clear()
    station.mode(AUTO)
    station.run(8)
    assert [text for text in station.texts if text.startswith("Mission: ")] == [
        "Mission: 1 ChangeSpeed",
        "Mission: 2 CondYaw",
        "Mission: 3 WP",
    ]
    assert math.degrees(autopilot.flight.attitude_rad[2]) == pytest.approx(90, abs=3)
    assert math.hypot(*autopilot.flight.velocity_m_s) == pytest.approx(2.0, abs=0.1)


def test_a_mission_goes_on_with_the_do_item_that_was_running() -> None:
    """A delay that was not over when AUTO was left begins anew, with the leg on which it ran."""
    autopilot, station = sim()
    station.fly()
    station.upload([item_at(5, 0), act(112, 5), act(178, 1, 1.0), item_at(200, 0)])
    station.mode(AUTO)
    assert station.run(60, lambda: autopilot.mission.seq == 4)
    station.run(2)
    station.mode(LOITER)
    station.clear()
    station.mode(AUTO)
    station.run(4)
    assert "Mission: 2 CondDelay" in station.texts
    assert math.hypot(*autopilot.flight.velocity_m_s) > 3.0
    station.run(14)
    assert math.hypot(*autopilot.flight.velocity_m_s) == pytest.approx(1.0, abs=0.1)


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
    station.upload([*SQUARE, item_at(0, 0), item_at(-40, 0)])
    station.mode(AUTO)
    station.run(1)
    for seq, moved, restarts in ((5, item_at(-20, 0), False), (1, item_at(25, 0), True)):
        station.clear()
        station.send(dialect.MAVLink_mission_write_partial_list_message(1, 1, seq, seq))
        command, frame, params, x, y, z = moved
        station.send(
            dialect.MAVLink_mission_item_int_message(1, 1, seq, frame, command, 0, 1, *params, x, y, z)
        )
        station.run(1)
        assert ("Auto mission changed, restarted command" in station.texts) == restarts
    assert station.run(200, lambda: 5 in station.reached())
    assert math.dist(autopilot.flight.position_m, (-20, 0, 20)) < 3


def test_a_mission_that_waits_on_the_ground_can_be_written_anew() -> None:
    """Disarmed in AUTO the first item is current; a new mission begins at its own first item."""
    autopilot, station = sim()
    station.run(READY_S)
    station.upload([takeoff(10), item_at(10, 0)])
    station.mode(AUTO)
    station.run(1)
    assert autopilot.mission.seq == 1
    station.send(dialect.MAVLink_mission_set_current_message(1, 1, 2))
    assert autopilot.mission.seq == 2
    station.upload([act(93, 1, -1, -1, -1), takeoff(20)])
    station.run(1)
    assert "Mission: 1 Delay" in station.texts
    station.upload([act(178, 1, 5)])
    station.run(1)
    station.channel.request(dialect.MAVLINK_MSG_ID_MISSION_CURRENT)
    assert station.last("MISSION_CURRENT").mission_state == dialect.MISSION_STATE_COMPLETE

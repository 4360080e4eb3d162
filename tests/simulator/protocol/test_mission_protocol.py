"""The mission protocol: uploads, read-back, refusals and timeouts, as ArduPilot answers them."""

from __future__ import annotations

import pytest

from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.faults import Faults, MissionFaults
from tests.helpers.sim_station import START, Item, Station, act, item_at, sim, takeoff

ACCEPTED, ERROR = dialect.MAV_MISSION_ACCEPTED, dialect.MAV_MISSION_ERROR
ROUTE = [takeoff(20), item_at(40, 0), act(178, 1, 5, -1), item_at(40, 40, command=82), act(20)]


def count(station: Station, number: int, mission_type: int = 0) -> None:
    station.send(dialect.MAVLink_mission_count_message(1, 1, number, mission_type))


def item(seq: int, what: Item, mission_type: int = 0) -> object:
    command, frame, params, x, y, z = what
    return dialect.MAVLink_mission_item_int_message(
        1, 1, seq, frame, command, 0, 1, *params, x, y, z, mission_type
    )


def ack(station: Station) -> tuple[int, int]:
    message = station.last("MISSION_ACK")
    return message.type, message.mission_type


def read_back(station: Station) -> list[object]:
    station.clear()
    station.send(dialect.MAVLink_mission_request_list_message(1, 1))
    for seq in range(station.last("MISSION_COUNT").count):
        station.send(dialect.MAVLink_mission_request_int_message(1, 1, seq))
    return station.of("MISSION_ITEM_INT")


def test_a_mission_comes_back_as_it_was_sent() -> None:
    """Upload and read-back agree; item 0 is home whatever was sent there."""
    autopilot, station = sim()
    station.run(6)
    assert station.upload(ROUTE) == ACCEPTED
    assert "Flight plan received" in station.texts
    back = read_back(station)
    sent = [(what[0], what[3], what[4], what[5]) for what in ROUTE]
    assert [(one.command, one.x, one.y, one.z) for one in back[1:]] == sent  # type: ignore[attr-defined]
    assert (back[0].x, back[0].y, back[0].z) == (START.lat_e7, START.lon_e7, 488.0)  # type: ignore[attr-defined]
    assert autopilot.parameters["MIS_TOTAL"] == len(ROUTE) + 1


def test_items_are_asked_for_one_by_one_with_mission_request() -> None:
    """ArduPilot asks with MISSION_REQUEST, in order, each once when nothing is lost."""
    _, station = sim()
    station.upload(ROUTE)
    assert [request.seq for request in station.of("MISSION_REQUEST")] == list(range(len(ROUTE) + 1))
    assert station.of("MISSION_REQUEST_INT") == []


def test_a_lost_item_is_asked_for_again_after_a_second() -> None:
    """The request is repeated each second of vehicle time, and the upload then goes on."""
    _, station = sim()
    count(station, 2)
    station.run(0.9)
    assert len(station.of("MISSION_REQUEST")) == 1
    station.run(1.3)
    assert [request.seq for request in station.of("MISSION_REQUEST")] == [0, 0, 0]
    station.send(item(0, item_at(0, 0)))
    station.send(item(1, item_at(10, 0)))
    assert ack(station) == (ACCEPTED, 0)


def test_a_silent_upload_is_cancelled_after_eight_seconds() -> None:
    """Eight seconds of vehicle time without an item end the upload, with an ACK and a text."""
    _, station = sim()
    count(station, 2)
    station.run(8.2)
    assert ack(station) == (dialect.MAV_MISSION_OPERATION_CANCELLED, 0)
    assert "Mission upload timeout" in station.texts
    station.send(item(0, item_at(0, 0)))
    assert ack(station) == (ERROR, 0)


def test_an_item_out_of_turn_is_an_invalid_sequence() -> None:
    """A repeated or early item is answered with INVALID_SEQUENCE and the upload goes on."""
    _, station = sim()
    count(station, 3)
    station.send(item(0, item_at(0, 0)))
    station.send(item(0, item_at(0, 0)))
    assert ack(station) == (dialect.MAV_MISSION_INVALID_SEQUENCE, 0)
    station.send(item(1, item_at(10, 0)))
    station.send(item(2, item_at(20, 0)))
    assert ack(station) == (ACCEPTED, 0)


def test_a_bad_item_ends_the_upload() -> None:
    """The code says what was wrong; what follows is answered with ERROR."""
    _, station = sim()
    count(station, 3)
    station.send(item(0, item_at(0, 0)))
    station.send(item(1, act(2999)))
    assert ack(station) == (dialect.MAV_MISSION_UNSUPPORTED, 0)
    station.send(item(2, item_at(20, 0)))
    assert ack(station) == (ERROR, 0)


@pytest.mark.parametrize(("target", "result"), [(0, ERROR), (9, ERROR), (1, ACCEPTED)])
def test_a_jump_must_lead_into_the_mission(target: int, result: int) -> None:
    """DO_JUMP to nowhere ends the upload."""
    _, station = sim()
    assert station.upload([item_at(10, 0), act(177, target, 2)]) == result


def test_another_station_is_denied_while_one_uploads() -> None:
    """Counts, items, reads and clears of others are refused; one's own new count begins anew."""
    _, station = sim()
    other = Station(station.link, 200, 1)
    count(station, 2)
    count(other, 5)
    assert ack(other)[0] == dialect.MAV_MISSION_DENIED
    other.send(item(0, item_at(0, 0)))
    assert ack(other)[0] == dialect.MAV_MISSION_DENIED
    other.send(dialect.MAVLink_mission_request_list_message(1, 1))
    assert ack(other)[0] == dialect.MAV_MISSION_DENIED
    other.send(dialect.MAVLink_mission_request_int_message(1, 1, 0))
    assert ack(other)[0] == dialect.MAV_MISSION_DENIED
    other.send(dialect.MAVLink_mission_clear_all_message(1, 1))
    assert ack(other)[0] == ERROR
    assert station.upload([item_at(10, 0)]) == ACCEPTED


def test_a_mission_that_is_too_long_is_refused() -> None:
    """One item more than there is room for is NO_SPACE, and says how many fit."""
    _, station = sim()
    count(station, 651)
    assert ack(station) == (dialect.MAV_MISSION_NO_SPACE, 0)
    assert "Only 650 items are supported" in station.texts
    count(station, 650)
    assert station.last("MISSION_REQUEST").seq == 0


def test_a_shorter_mission_leaves_nothing_of_the_longer() -> None:
    """A new count cuts the old mission; none at all empties it."""
    _, station = sim()
    station.upload(ROUTE)
    station.upload([item_at(10, 0)])
    assert len(read_back(station)) == 2
    count(station, 0)
    assert ack(station) == (ACCEPTED, 0)
    assert read_back(station) == []


def test_part_of_a_mission_can_be_written() -> None:
    """A partial write replaces its items, and may not reach beyond the end."""
    _, station = sim()
    station.upload([item_at(10, 0), item_at(20, 0), item_at(30, 0)])
    station.clear()
    station.send(dialect.MAVLink_mission_write_partial_list_message(1, 1, 2, 2))
    assert station.last("MISSION_REQUEST").seq == 2
    station.send(item(2, item_at(25, 0)))
    assert ack(station) == (ACCEPTED, 0)
    assert [one.x for one in read_back(station)][2] == item_at(25, 0)[3]  # type: ignore[attr-defined]
    station.send(dialect.MAVLink_mission_write_partial_list_message(1, 1, 3, 9))
    assert ack(station) == (ERROR, 0)


def test_reading_beyond_the_end_tells_the_length() -> None:
    """A request for an item that is not there brings the count and an error."""
    _, station = sim()
    station.upload([item_at(10, 0)])
    station.clear()
    station.send(dialect.MAVLink_mission_request_int_message(1, 1, 2))
    assert station.last("MISSION_COUNT").count == 2
    assert ack(station) == (ERROR, 0)


def test_home_can_be_read_of_an_empty_mission() -> None:
    """Item 0 is there even when the count is 0."""
    _, station = sim()
    station.run(6)
    station.send(dialect.MAVLink_mission_request_message(1, 1, 0))
    assert station.last("MISSION_ITEM").x == pytest.approx(START.lat_deg, abs=4e-6)
    assert "got MISSION_REQUEST; use MISSION_REQUEST_INT!" in station.texts


def test_fences_and_rally_points_are_empty_lists() -> None:
    """They read as empty and can be cleared, but not written; other lists are unknown."""
    _, station = sim()
    for kind in (dialect.MAV_MISSION_TYPE_FENCE, dialect.MAV_MISSION_TYPE_RALLY):
        station.send(dialect.MAVLink_mission_request_list_message(1, 1, kind))
        assert (station.last("MISSION_COUNT").count, station.last("MISSION_COUNT").mission_type) == (0, kind)
        station.send(dialect.MAVLink_mission_clear_all_message(1, 1, kind))
        assert ack(station) == (ACCEPTED, kind)
        count(station, 0, kind)
        assert ack(station) == (ACCEPTED, kind)
        count(station, 3, kind)
        assert ack(station) == (dialect.MAV_MISSION_NO_SPACE, kind)
    station.send(dialect.MAVLink_mission_request_list_message(1, 1, 9))
    assert ack(station) == (dialect.MAV_MISSION_UNSUPPORTED, 9)
    count(station, 1, 9)
    assert ack(station) == (dialect.MAV_MISSION_UNSUPPORTED, 9)


def test_an_upload_in_floats_is_taken_and_complained_of_once() -> None:
    """MISSION_ITEM still works; ArduPilot asks for the other form, once."""
    _, station = sim()
    count(station, 2)
    for seq in range(2):
        station.send(
            dialect.MAVLink_mission_item_message(1, 1, seq, 3, 16, 0, 1, 0, 0, 0, 0, 47.3977, 8.5455, 20)
        )
    assert ack(station) == (ACCEPTED, 0)
    assert station.texts.count("got MISSION_ITEM; GCS should send MISSION_ITEM_INT") == 1


def test_faults_refuse_an_item_the_whole_or_the_newer_form() -> None:
    """A fault script's result answers its item, the last item, or nothing at all."""
    _, station = sim(Faults(mission=MissionFaults(result_of_item={2: 14})))
    assert station.upload([item_at(1, 0)]) == ACCEPTED
    assert station.upload(ROUTE) == ERROR
    assert 14 in [message.type for message in station.of("MISSION_ACK")]
    _, station = sim(Faults(mission=MissionFaults(result_of_upload=ERROR)))
    assert station.upload([item_at(1, 0)]) == ERROR
    _, station = sim(Faults(mission=MissionFaults(capacity=3)))
    assert station.upload([item_at(1, 0)]) == ACCEPTED
    count(station, 4)
    assert ack(station)[0] == dialect.MAV_MISSION_NO_SPACE
    _, station = sim(Faults(mission=MissionFaults(supports_item_int=False)))
    count(station, 2)
    station.send(item(0, item_at(0, 0)))
    assert station.of("MISSION_ACK") == []
    assert [request.seq for request in station.of("MISSION_REQUEST")] == [0]

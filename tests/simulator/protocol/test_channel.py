"""A link's end at the vehicle: versions, damage, pace; in vehicle time."""

from __future__ import annotations

from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.faults import Faults
from tests.helpers.sim_station import GUIDED, LOITER, Station, sim

ALL = dialect.MAV_DATA_STREAM_ALL


def test_mavlink_2_is_spoken_from_the_start() -> None:
    """As ArduPilot does with SERIAL0_PROTOCOL 2, even to a station that speaks MAVLink 1."""
    _, station = sim()
    old = Station(station.link, 254, old=True)
    old.send(dialect.MAVLink_param_request_read_message(1, 1, b"RTL_ALT", -1))
    assert {raw[0] for raw in old.raw} == {dialect.PROTOCOL_MARKER_V2}


def test_mavlink_1_is_spoken_when_set_until_mavlink_2_comes_in() -> None:
    """SERIAL0_PROTOCOL 1 begins in MAVLink 1, without extension fields and messages above 255."""
    _, first = sim(SERIAL0_PROTOCOL=1)
    station = Station(first.link, 254, old=True)
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, ALL, 4, 1))
    station.run(3)
    assert {raw[0] for raw in station.raw} == {dialect.PROTOCOL_MARKER_V1}
    assert station.of("RC_CHANNELS_RAW") != []
    assert station.of("BAD_DATA") == []
    current = next(raw for raw in station.raw if raw[5] == dialect.MAVLINK_MSG_ID_MISSION_CURRENT)
    assert len(current) == 8 + 2
    assert station.texts[-1] == "GPS 1: detected u-blox"
    station.channel.send(dialect.MAVLink_relay_status_message(0, 0, 0))
    assert station.of("RELAY_STATUS") == []
    Station(station.link, 1).send(dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))
    assert station.channel.mavlink1
    for message, sender in station.channel.receive(
        dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3).pack(station.mav)
    ):
        station.link.handle(message, sender)
    assert not station.channel.mavlink1


def test_damaged_bytes_are_dropped() -> None:
    """Noise between messages and a broken checksum cost no more than the message they hit."""
    autopilot, station = sim()
    good = dialect.MAVLink_set_mode_message(1, 1, GUIDED).pack(station.mav)
    bad = bytearray(dialect.MAVLink_set_mode_message(1, 1, LOITER).pack(station.mav))
    bad[-1] ^= 0xFF
    for data in (b"\x00\x17noise", bytes(bad), good[:5], good[5:]):
        for message, sender in station.channel.receive(data):
            station.link.handle(message, sender)
    assert autopilot.mode.value == GUIDED


def test_a_full_link_leaves_telemetry_out() -> None:
    """While the link takes no more, nothing is piled up, and answers still go out."""
    autopilot, station = sim()
    station.channel._has_room = lambda: False
    station.run(5)
    assert station.of("HEARTBEAT") == []
    assert station.mode(LOITER) == 0
    assert autopilot.mode.value == LOITER


def test_sequence_numbers_count_every_message() -> None:
    """A station can count losses: numbers follow each other, modulo 256."""
    _, station = sim(Faults())
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, ALL, 10, 1))
    station.run(10)
    numbers = [message.get_seq() for message in station.received]
    assert numbers == [index % 256 for index in range(len(numbers))]


def test_ping_timesync_and_files_are_answered() -> None:
    """A ping comes back, the time is told, and files are refused at once."""
    autopilot, station = sim()
    station.run(2)
    station.send(dialect.MAVLink_ping_message(77, 5, 0, 0))
    ping = station.last("PING")
    assert (ping.time_usec, ping.seq, ping.target_system, ping.target_component) == (77, 5, 255, 190)
    station.send(dialect.MAVLink_timesync_message(0, 123))
    assert (station.last("TIMESYNC").tc1, station.last("TIMESYNC").ts1) == (int(autopilot.time_s * 1e9), 123)
    request = [7, 0, 3, 4, *([0] * 247)]
    station.send(dialect.MAVLink_file_transfer_protocol_message(0, 1, 1, request))
    answer = station.last("FILE_TRANSFER_PROTOCOL").payload
    assert (answer[0], answer[2], answer[3], answer[5], answer[12]) == (8, 3, 129, 4, 10)
    station.clear()
    station.send(dialect.MAVLink_ping_message(77, 5, 1, 1))
    station.send(dialect.MAVLink_timesync_message(5, 123))
    assert station.received == []


def test_the_version_tells_what_it_can_do() -> None:
    """AUTOPILOT_VERSION by both ways of asking: 4.6.0, with the capabilities that it has."""
    _, station = sim()
    assert station.command(520, 1) == 0
    version = station.last("AUTOPILOT_VERSION")
    assert version.flight_sw_version >> 8 == 0x040600
    for name in ("MISSION_INT", "COMMAND_INT", "MAVLINK2", "MISSION_FENCE"):
        assert version.capabilities & getattr(dialect, f"MAV_PROTOCOL_CAPABILITY_{name}")
    station.clear()
    station.send(dialect.MAVLink_autopilot_version_request_message(1, 1))
    assert len(station.of("AUTOPILOT_VERSION")) == 1
    assert station.command(520, 0) == 4
    assert station.command(42428) == 0
    assert "flight-replay's built-in copter, not ArduPilot" in station.texts
    assert station.command(31999) == 3
    assert station.command(241) == 0

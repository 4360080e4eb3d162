"""What streams and what is told when asked; in vehicle time."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest

from flight_replay.mavlink import dialect
from flight_replay.simulator.flight.guided import GuidedTarget
from flight_replay.simulator.protocol.stream_rates import GROUPS, StreamRates
from flight_replay.simulator.protocol.telemetry import BUILDERS
from tests.helpers.sim_station import START, Station, item_at, sim

ALL = dialect.MAV_DATA_STREAM_ALL
ATTITUDE, VFR_HUD = dialect.MAVLINK_MSG_ID_ATTITUDE, dialect.MAVLINK_MSG_ID_VFR_HUD
SET_INTERVAL, GET_INTERVAL, REQUEST = 511, 510, 512


def counts(station: Station) -> Counter[str]:
    return Counter(message.get_type() for message in station.received)


def test_only_heartbeats_come_unasked() -> None:
    """Like ArduPilot with SR0_* at 0, a new link carries heartbeats and texts alone, one a second."""
    _, station = sim()
    station.run(10)
    received = counts(station)
    assert received["HEARTBEAT"] in (10, 11)
    assert set(received) == {"HEARTBEAT", "STATUSTEXT", "HOME_POSITION", "GPS_GLOBAL_ORIGIN"}


def test_streams_come_at_the_rate_asked_for_by_vehicle_time() -> None:
    """4 Hz of everything is 4 messages a second of every kind that ArduCopter would send."""
    _, station = sim()
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, ALL, 4, 1))
    station.run(10)
    station.clear()
    station.run(10)
    received = counts(station)
    kinds = "ATTITUDE GLOBAL_POSITION_INT SYS_STATUS GPS_RAW_INT MISSION_CURRENT EKF_STATUS_REPORT VFR_HUD"
    for kind in f"{kinds} BATTERY_STATUS RC_CHANNELS LOCAL_POSITION_NED".split():
        assert received[kind] in (40, 41), kind
    assert received["RC_CHANNELS_RAW"] == received["POSITION_TARGET_GLOBAL_INT"] == 0


def test_streams_stop_when_told_to() -> None:
    """start_stop 0 ends a stream; other values change nothing."""
    _, station = sim()
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, 10, 5, 1))
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, 10, 0, 7))
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, 99, 5, 1))
    station.run(1)
    assert counts(station)["ATTITUDE"] in (5, 6)
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, 10, 5, 0))
    station.clear()
    station.run(1)
    assert counts(station)["ATTITUDE"] == 0


def test_each_station_has_rates_of_its_own() -> None:
    """What one link asks for does not show on another."""
    _, station = sim()
    other = Station(station.link, 254)
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, ALL, 2, 1))
    other.send(dialect.MAVLink_request_data_stream_message(1, 1, 11, 10, 1))
    station.run(5)
    assert counts(station)["VFR_HUD"] in (10, 11)
    assert counts(other)["VFR_HUD"] in (50, 51)
    assert counts(other)["ATTITUDE"] == 0


def test_single_messages_have_intervals() -> None:
    """SET_MESSAGE_INTERVAL sets, stops and restores; GET tells; unknown messages are denied."""
    _, station = sim()
    assert station.command(SET_INTERVAL, ATTITUDE, 100000) == 0
    assert station.command(GET_INTERVAL, ATTITUDE) == 0
    assert station.last("MESSAGE_INTERVAL").interval_us == 100000
    station.run(2)
    assert counts(station)["ATTITUDE"] == 20
    assert station.command(SET_INTERVAL, ATTITUDE, -1) == 0
    station.command(GET_INTERVAL, ATTITUDE)
    assert station.last("MESSAGE_INTERVAL").interval_us == -1
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, ALL, 2, 1))
    station.command(SET_INTERVAL, ATTITUDE, 50000)
    station.command(SET_INTERVAL, ATTITUDE, 0)
    station.command(GET_INTERVAL, ATTITUDE)
    assert station.last("MESSAGE_INTERVAL").interval_us == 500000
    assert station.command(SET_INTERVAL, 12345, 1000) == 2
    assert station.command(GET_INTERVAL, 12345) == 4
    assert station.last("MESSAGE_INTERVAL").interval_us == 0


def test_heartbeats_go_back_to_one_a_second() -> None:
    """Interval 0 is the default, which for HEARTBEAT is not "never"."""
    rates = StreamRates({})
    rates.set_message(dialect.MAVLINK_MSG_ID_HEARTBEAT, None)
    assert rates.due(1.0) == []
    rates.set_message(dialect.MAVLINK_MSG_ID_HEARTBEAT, 0)
    assert rates.interval_s(dialect.MAVLINK_MSG_ID_HEARTBEAT) == 1.0
    rates.set_message(12345, 0)
    assert rates.interval_s(12345) is None


def test_a_late_message_is_sent_once() -> None:
    """After a pause nothing is made up for."""
    rates = StreamRates({dialect.MAV_DATA_STREAM_EXTRA2: 10.0})
    assert VFR_HUD in rates.due(0.0)
    assert rates.due(0.05) == []
    assert rates.due(5.0).count(VFR_HUD) == 1
    assert VFR_HUD not in rates.due(5.05)


def test_every_message_can_be_requested() -> None:
    """REQUEST_MESSAGE brings each message that is known, on the ground, in flight and in AUTO."""
    _, station = sim()
    station.fly()
    station.upload([item_at(100, 0)])
    station.mode(3)
    station.run(2)
    missing = {"RC_CHANNELS_RAW", "FENCE_STATUS"}
    for message_id in BUILDERS:
        station.clear()
        assert station.command(REQUEST, message_id) == 0
        kind = dialect.mavlink_map[message_id].msgname
        assert (station.of(kind) == []) == (kind in missing), kind
    assert station.command(REQUEST, 12345) == 4


def test_above_the_air_there_is_no_pressure() -> None:
    """Where the formula of the standard atmosphere has no real value."""
    _, station = sim(start=replace(START, alt_amsl_m=50_000.0))
    assert station.command(REQUEST, dialect.MAVLINK_MSG_ID_SCALED_PRESSURE) == 0
    assert [each.press_abs for each in station.of("SCALED_PRESSURE")] == [0.0]


def test_streams_are_made_of_messages_that_exist() -> None:
    """Every message of a group can be built."""
    assert {message_id for group in GROUPS.values() for message_id in group} <= set(BUILDERS)


def test_telemetry_tells_where_the_copter_is() -> None:
    """Positions, heights, speeds and headings of different messages agree."""
    autopilot, station = sim()
    station.fly()
    autopilot.parameters.assign("GUID_TIMEOUT", 60)
    autopilot.flight.follow(GuidedTarget(velocity_m_s=(3.0, 4.0, 0.0)))
    station.run(10)
    for name in ("GLOBAL_POSITION_INT", "GPS_RAW_INT", "VFR_HUD", "LOCAL_POSITION_NED", "AHRS2", "SIMSTATE",
                 "ATTITUDE", "ATTITUDE_QUATERNION", "EXTENDED_SYS_STATE"):  # fmt: skip
        station.channel.request(getattr(dialect, f"MAVLINK_MSG_ID_{name}"))
    north_m, east_m, up_m = autopilot.flight.position_m
    there = START.location_of((north_m, east_m, up_m))
    position = station.last("GLOBAL_POSITION_INT")
    assert (position.lat, position.lon, position.alt) == (there.lat_e7, there.lon_e7, there.alt_mm)
    assert position.relative_alt == pytest.approx(up_m * 1000, abs=2)
    assert (position.vx, position.vy) == pytest.approx((300, 400), abs=2)
    assert station.last("GPS_RAW_INT").vel == pytest.approx(500, abs=2)
    assert station.last("GPS_RAW_INT").cog == pytest.approx(5313, abs=10)
    assert station.last("VFR_HUD").groundspeed == pytest.approx(5, abs=0.01)
    assert station.last("LOCAL_POSITION_NED").x == pytest.approx(north_m, abs=0.01)
    assert station.last("AHRS2").lat == station.last("SIMSTATE").lat == there.lat_e7
    assert station.last("EXTENDED_SYS_STATE").landed_state == dialect.MAV_LANDED_STATE_IN_AIR
    quaternion = station.last("ATTITUDE_QUATERNION")
    assert quaternion.q1**2 + quaternion.q2**2 + quaternion.q3**2 + quaternion.q4**2 == pytest.approx(1)


def test_before_the_fix_there_is_no_position() -> None:
    """Like ArduPilot, GLOBAL_POSITION_INT is 0 and LOCAL_POSITION_NED absent until GPS and EKF are up."""
    _, station = sim()
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, ALL, 4, 1))
    station.run(2.5)
    assert {(m.lat, m.lon) for m in station.of("GLOBAL_POSITION_INT")} == {(0, 0)}
    assert {m.fix_type for m in station.of("GPS_RAW_INT")} == {0, 1}
    assert station.of("LOCAL_POSITION_NED") == []
    station.run(6)
    assert station.last("GLOBAL_POSITION_INT").lat == START.lat_e7
    assert station.last("GPS_RAW_INT").fix_type == 6
    assert [m.flags for m in station.of("EKF_STATUS_REPORT")][::20] == [1024, 167]
    assert station.last("EKF_STATUS_REPORT").flags == 831


def test_absurd_parameters_do_not_end_the_simulation() -> None:
    """Energy that its field cannot hold is reported as the most that it can."""
    _, station = sim(SIM_BATT_VOLTAGE=1e30)
    station.run(10)
    station.command(400, 1, 2989)
    station.run(1)
    station.channel.request(dialect.MAVLINK_MSG_ID_BATTERY_STATUS)
    assert station.last("BATTERY_STATUS").energy_consumed == 2**31 - 1

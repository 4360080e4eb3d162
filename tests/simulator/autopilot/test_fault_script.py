"""Fault scripts: what can be made to go wrong, and when."""

from __future__ import annotations

import pytest

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.faults import (
    ADSB_RECEIVER,
    GIMBAL,
    PLANE,
    RADIO,
    SECOND_COPTER,
    FailsafeMode,
    Faults,
    MoveItem,
    PilotMode,
    Reboot,
    ScriptedFault,
    SetParameter,
    old_copter,
)
from tests.helpers.sim_station import ARM, AUTO, GUIDED, READY_S, SET_MODE, TAKEOFF, item_at, sim


def test_the_pilot_takes_over() -> None:
    """A mode change by the pilot comes after its trigger, and only once."""
    autopilot, station = sim(Faults(script=(ScriptedFault("AUTO", 5, PilotMode(CopterMode.LOITER)),)))
    station.fly()
    station.upload([item_at(500, 0)])
    station.mode(AUTO)
    station.run(4.9)
    assert autopilot.mode.name == "AUTO"
    station.run(0.3)
    assert autopilot.mode == CopterMode.LOITER
    station.mode(AUTO)
    station.run(10)
    assert autopilot.mode.value == AUTO


def test_the_vehicle_decides_for_itself() -> None:
    """A failsafe of the vehicle's own changes the mode and is announced; parameters can change too."""
    script = (
        ScriptedFault("takeoff", 3, SetParameter("SIM_BATT_VOLTAGE", 11.0)),
        ScriptedFault("armed", 20, FailsafeMode(CopterMode.LAND, "EKF Failsafe: changed to LAND Mode")),
    )
    autopilot, station = sim(Faults(script=script))
    station.fly(10)
    station.run(20)
    assert autopilot.mode == CopterMode.LAND
    assert "EKF Failsafe: changed to LAND Mode" in station.texts
    assert autopilot.battery.voltage_v == 11.0


def test_a_reboot_forgets_the_flight() -> None:
    """After a reboot in the air time begins anew, disarmed in STABILIZE on the ground, mission kept."""
    autopilot, station = sim(Faults(script=(ScriptedFault("AUTO", 5, Reboot()),)))
    station.send(dialect.MAVLink_request_data_stream_message(1, 1, 0, 4, 1))
    station.fly()
    station.upload([item_at(500, 0)])
    station.mode(AUTO)
    station.run(6)
    assert autopilot.time_s < 2
    assert (autopilot.mode, autopilot.armed, autopilot.flight.landed) == (CopterMode.STABILIZE, False, True)
    assert len(autopilot.store) == 2
    station.clear()
    station.run(3)
    assert {message.get_type() for message in station.received} == {"HEARTBEAT", "STATUSTEXT"}
    station.fly()


def test_a_reboot_can_be_asked_for_on_the_ground() -> None:
    """PREFLIGHT_REBOOT_SHUTDOWN is refused armed, and in forms that ArduCopter has not."""
    autopilot, station = sim()
    station.run(READY_S)
    assert station.command(246, 2) == 3
    assert station.command(246, 1) == 0
    assert autopilot.time_s == 0
    station.fly()
    assert station.command(246, 1) == 4


def test_another_station_changes_the_mission() -> None:
    """Shortly after the upload an item is elsewhere on board."""
    autopilot, station = sim(Faults(script=(ScriptedFault("upload", 0.5, MoveItem(1)),)))
    station.upload([item_at(50, 0)])
    before = autopilot.store.items[1]
    station.run(1)
    moved = autopilot.store.items[1]
    assert (moved.lat_e7 - before.lat_e7) * 1.11e-2 == pytest.approx(20, abs=0.1)
    assert moved.lon_e7 == before.lon_e7


def test_others_are_heard_on_the_same_link() -> None:
    """Heartbeats of gimbal, radio, ADS-B receiver and a second copter come with their own addresses."""
    others = (GIMBAL, RADIO, ADSB_RECEIVER, SECOND_COPTER)
    _, station = sim(Faults(other_heartbeats=others))
    station.run(3)
    received = {(m.get_srcSystem(), m.get_srcComponent(), m.type) for m in station.of("HEARTBEAT")}
    assert received == {(1, 1, 2), *((other.system, other.component, other.vehicle_type) for other in others)}
    assert {(m.get_srcSystem(), m.relative_alt) for m in station.of("GLOBAL_POSITION_INT")} == {(2, 77000)}


def test_it_can_be_a_plane() -> None:
    """The heartbeat's type and the banner are another vehicle's."""
    _, station = sim(Faults(firmware=PLANE))
    station.run(1)
    assert station.last("HEARTBEAT").type == dialect.MAV_TYPE_FIXED_WING
    station.send(dialect.MAVLink_param_request_list_message(1, 1))
    assert any(text.startswith("ArduPlane V4.6.0") for text in station.texts)


def test_an_old_copter_knows_less() -> None:
    """ArduCopter 3.3: no TIMESYNC, modes by SET_MODE only, slow arming that each repeat starts again."""
    autopilot, station = sim(old_copter())
    assert autopilot.parameters["FS_GCS_ENABLE"] == 1
    station.run(READY_S)
    station.send(dialect.MAVLink_timesync_message(0, 123))
    assert station.of("TIMESYNC") == []
    assert station.command(SET_MODE, 1, GUIDED) == 3
    assert station.command(512, 30) == 3
    station.send(dialect.MAVLink_set_mode_message(1, 1, GUIDED))
    assert (station.last("COMMAND_ACK").command, station.last("COMMAND_ACK").result) == (11, 0)
    assert autopilot.mode == CopterMode.GUIDED
    assert station.command(ARM, 1) == 0
    for _ in range(4):
        station.run(1)
        assert not autopilot.armed
        assert station.command(ARM, 1) == 0
    station.run(2.6)
    assert autopilot.armed
    assert station.command(TAKEOFF, 0, 0, 0, 0, 0, 0, 10) == 0
    assert {raw[0] for raw in station.raw} == {dialect.PROTOCOL_MARKER_V1}

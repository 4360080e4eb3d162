"""Failsafes and the battery."""

from __future__ import annotations

import pytest

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.battery import Battery, BatteryFailsafe
from flight_replay.simulator.autopilot.parameter_table import Parameters
from tests.helpers.sim_station import ARM, AUTO, GUIDED, READY_S, Station, item_at, sim


def gcs_heartbeat(station: Station) -> None:
    station.send(dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))


@pytest.mark.parametrize(
    ("enable", "options", "mode", "text"),
    [
        (0, 0, CopterMode.GUIDED, None),
        (1, 0, CopterMode.RTL, "GCS Failsafe"),
        (3, 0, CopterMode.RTL, "GCS Failsafe"),
        (5, 0, CopterMode.LAND, "GCS Failsafe"),
        (7, 0, CopterMode.BRAKE, "GCS Failsafe"),
        (1, 1 << 4, CopterMode.RTL, "GCS Failsafe"),
    ],
)
def test_a_silent_ground_station_trips_the_failsafe(
    enable: int, options: int, mode: CopterMode, text: str | None
) -> None:
    """Five seconds of vehicle time after the last heartbeat, as FS_GCS_ENABLE says; 0 is off."""
    autopilot, station = sim(FS_GCS_ENABLE=enable, FS_OPTIONS=options)
    gcs_heartbeat(station)
    autopilot.parameters.assign("FS_GCS_TIMEOUT", 100)
    station.fly()
    gcs_heartbeat(station)
    autopilot.parameters.assign("FS_GCS_TIMEOUT", 5)
    station.run(4.8)
    assert autopilot.mode == CopterMode.GUIDED
    station.run(0.5)
    assert autopilot.mode == mode
    assert (text in station.texts) == (text is not None)
    gcs_heartbeat(station)
    station.run(0.5)
    assert ("GCS Failsafe Cleared" in station.texts) == (text is not None)


def test_a_station_that_was_never_heard_is_not_missed() -> None:
    """Without a first heartbeat of SYSID_MYGCS there is no failsafe."""
    autopilot, station = sim(FS_GCS_ENABLE=1)
    station.fly()
    station.run(20)
    assert autopilot.mode == CopterMode.GUIDED


def test_missions_and_pilots_may_go_on_without_a_station() -> None:
    """FS_OPTIONS lets AUTO continue, and pilot modes; disarmed it is only said, and keeps from arming."""
    autopilot, station = sim(FS_GCS_ENABLE=1, FS_OPTIONS=2 | 16)
    gcs_heartbeat(station)
    station.run(READY_S)
    assert "GCS Failsafe" in station.texts
    station.mode(GUIDED)
    assert station.command(ARM, 1) == 4
    assert station.texts[-1] == "Arm: GCS failsafe on"
    gcs_heartbeat(station)
    autopilot.parameters.assign("FS_GCS_TIMEOUT", 30)
    station.fly()
    station.upload([item_at(500, 0)])
    station.mode(AUTO)
    station.run(40)
    assert autopilot.mode == CopterMode.AUTO
    assert "GCS Failsafe - Continuing Auto Mode" in station.texts
    assert station.last("HEARTBEAT").system_status == dialect.MAV_STATE_CRITICAL
    gcs_heartbeat(station)
    station.run(1)
    station.mode(CopterMode.LOITER)
    station.run(40)
    assert "GCS Failsafe - Continuing Pilot Control" in station.texts


@pytest.mark.parametrize(
    ("action", "mode"), [(0, CopterMode.GUIDED), (1, CopterMode.LAND), (2, CopterMode.RTL)]
)
def test_a_low_battery_does_what_its_parameter_says(action: int, mode: CopterMode) -> None:
    """Ten seconds below BATT_LOW_VOLT, BATT_FS_LOW_ACT is carried out, with volts and mAh in the text."""
    autopilot, station = sim(BATT_FS_LOW_ACT=action)
    station.fly()
    autopilot.parameters.assign("SIM_BATT_VOLTAGE", 10.2)
    station.run(9)
    assert autopilot.mode == CopterMode.GUIDED
    station.run(2)
    assert autopilot.mode == mode
    assert any(text.startswith("Battery 1 is low 10.20V used") for text in station.texts)
    station.channel.request(dialect.MAVLINK_MSG_ID_BATTERY_STATUS)
    assert station.last("BATTERY_STATUS").charge_state == dialect.MAV_BATTERY_CHARGE_STATE_LOW


def test_a_failsafe_waits_before_it_lands() -> None:
    """LAND of a failsafe holds the height for four seconds, LAND of a station does not."""
    autopilot, station = sim(BATT_FS_LOW_ACT=1)
    station.fly()
    autopilot.parameters.assign("SIM_BATT_VOLTAGE", 10.2)
    assert station.run(12, lambda: autopilot.mode == CopterMode.LAND)
    station.run(3.9)
    assert autopilot.above_home_m == pytest.approx(20, abs=0.2)
    station.run(4)
    assert autopilot.above_home_m < 17
    autopilot, station = sim()
    station.fly()
    station.mode(CopterMode.LAND)
    station.run(4)
    assert autopilot.above_home_m < 17


def test_a_critical_battery_goes_beyond_a_low_one() -> None:
    """Charge counts at once; critical acts after low has; on the ground the motors stop."""
    autopilot, station = sim(BATT_LOW_MAH=3200, BATT_FS_LOW_ACT=2, BATT_CRT_MAH=3150, BATT_FS_CRT_ACT=1)
    station.fly(10)
    assert station.run(60, lambda: autopilot.mode == CopterMode.RTL)
    assert station.run(60, lambda: autopilot.mode == CopterMode.LAND)
    station.run(60, lambda: not autopilot.armed)
    assert station.command(ARM, 1) == 4
    autopilot, station = sim(BATT_LOW_VOLT=0, BATT_FS_LOW_ACT=2)
    station.run(READY_S)
    station.mode(GUIDED)
    station.command(ARM, 1)
    autopilot.parameters.assign("BATT_LOW_MAH", 4000)
    station.run(1)
    assert not autopilot.armed
    assert "Battery Failsafe - Disarming" in station.texts


def test_a_landing_goes_on_through_a_failsafe_and_a_termination_stops_the_motors() -> None:
    """FS_OPTIONS bit 3 lets LAND continue; action 5 disarms in the air."""
    autopilot, station = sim(BATT_FS_LOW_ACT=2, FS_OPTIONS=8)
    station.fly(30)
    station.mode(CopterMode.LAND)
    autopilot.parameters.assign("BATT_LOW_MAH", 4000)
    station.run(1)
    assert autopilot.mode == CopterMode.LAND
    autopilot, station = sim(BATT_FS_LOW_ACT=5)
    station.fly(30)
    autopilot.parameters.assign("BATT_LOW_MAH", 4000)
    station.run(1)
    assert not autopilot.armed


def test_the_battery_empties_with_the_flight() -> None:
    """A minute of hovering takes about 470 mAh, and with a capacity the voltage falls too."""
    parameters = Parameters({"SIM_BATT_CAP_AH": 3.3})
    battery = Battery(parameters)
    for _ in range(60):
        battery.draw(1.0, armed=True, landed=False, climb_m_s=0.0)
    assert battery.consumed_mah == pytest.approx(468, abs=2)
    assert battery.remaining_percent == 85
    assert 12.0 < battery.voltage_v < 12.6
    assert battery.failsafe == BatteryFailsafe.NONE
    parameters.assign("BATT_CAPACITY", 0)
    assert battery.remaining_percent == 0

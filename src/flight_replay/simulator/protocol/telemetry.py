"""The autopilot's state as MAVLink messages: one builder for each message number.

A builder returns None while ArduCopter does not send the message: LOCAL_POSITION_NED before the EKF
has a position, for instance. Flags and constants are those of an ArduCopter 4.6 SITL.
"""

from __future__ import annotations

from collections.abc import Callable

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.modes import GUIDED_FLAG, MANUAL_THROTTLE, NEEDS_POSITION
from flight_replay.simulator.protocol.telemetry_motion import MOTION
from flight_replay.simulator.protocol.telemetry_sensors import SENSORS

Builder = Callable[[Autopilot], Message | None]

# MAV_SYS_STATUS_SENSOR masks of a disarmed SITL copter without GPS; the rest is added when it starts.
_PRESENT, _ENABLED, _HEALTHY = 1399979023, 1380031503, 1196530703
_GPS = dialect.MAV_SYS_STATUS_SENSOR_GPS
_AHRS = dialect.MAV_SYS_STATUS_AHRS
_PREARM = dialect.MAV_SYS_STATUS_PREARM_CHECK
_LOGGING = dialect.MAV_SYS_STATUS_LOGGING
_BATTERY = dialect.MAV_SYS_STATUS_SENSOR_BATTERY
_ALTITUDE_CONTROL = dialect.MAV_SYS_STATUS_SENSOR_Z_ALTITUDE_CONTROL
_POSITION_CONTROL = dialect.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL
_IN_DEVELOPMENT = 0  # FIRMWARE_VERSION_TYPE; a released 4.6 turns corners in another way.


def heartbeat(autopilot: Autopilot) -> Message:
    """HEARTBEAT with the mode, the armed flag, and standby, active or critical."""
    flags = dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | dialect.MAV_MODE_FLAG_STABILIZE_ENABLED
    flags |= dialect.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
    if autopilot.mode in GUIDED_FLAG:
        flags |= dialect.MAV_MODE_FLAG_GUIDED_ENABLED
    if autopilot.armed:
        flags |= dialect.MAV_MODE_FLAG_SAFETY_ARMED
    status = dialect.MAV_STATE_STANDBY if autopilot.flight.landed else dialect.MAV_STATE_ACTIVE
    if autopilot.failsafes.any_active:
        status = dialect.MAV_STATE_CRITICAL
    vehicle_type = autopilot.faults.firmware.vehicle_type
    return dialect.MAVLink_heartbeat_message(
        vehicle_type, dialect.MAV_AUTOPILOT_ARDUPILOTMEGA, flags, int(autopilot.mode), status, 3
    )


def _sys_status(autopilot: Autopilot) -> Message:
    present, enabled, healthy = _PRESENT, _ENABLED, _HEALTHY
    if autopilot.sensors.fix_type > 0:
        present, enabled, healthy = present | _GPS, enabled | _GPS, healthy | _GPS
    if autopilot.sensors.origin_set:
        enabled, healthy = enabled | _AHRS, healthy | _AHRS
    if autopilot.armed:
        control = 0 if autopilot.mode in MANUAL_THROTTLE else _ALTITUDE_CONTROL
        control |= (
            _POSITION_CONTROL if autopilot.mode in NEEDS_POSITION or autopilot.mode == CopterMode.LAND else 0
        )
        enabled, healthy = enabled | _LOGGING | control, healthy | control
    if autopilot.armed or autopilot.prearm.passed:
        healthy |= _PREARM
    if autopilot.battery.failsafe:
        healthy &= ~_BATTERY
    battery = autopilot.battery
    return dialect.MAVLink_sys_status_message(
        present, enabled, healthy, 0, _millivolts(autopilot), round(battery.current_a * 100),
        battery.remaining_percent, 0, 0, 0, 0, 0, 0,
    )  # fmt: skip


def _millivolts(autopilot: Autopilot) -> int:
    return min(max(round(autopilot.battery.voltage_v * 1000), 0), 65534)


def _int32(value: float) -> int:
    return min(max(round(value), -(2**31)), 2**31 - 1)


def _battery_status(autopilot: Autopilot) -> Message:
    battery = autopilot.battery
    unused = 65535
    voltages = [_millivolts(autopilot), *([unused] * 9)]
    states = (dialect.MAV_BATTERY_CHARGE_STATE_OK, dialect.MAV_BATTERY_CHARGE_STATE_LOW,
              dialect.MAV_BATTERY_CHARGE_STATE_CRITICAL)  # fmt: skip
    return dialect.MAVLink_battery_status_message(
        0, 0, 0, 32767, voltages, round(battery.current_a * 100), round(battery.consumed_mah),
        _int32(battery.consumed_wh * 36), battery.remaining_percent, 0, states[battery.failsafe],
    )  # fmt: skip


def _mission_current(autopilot: Autopilot) -> Message:
    return mission_current(autopilot, autopilot.mission.seq)


def mission_current(autopilot: Autopilot, seq: int) -> Message:
    """MISSION_CURRENT with a given number, which answers a station's MISSION_SET_CURRENT."""
    total = max(len(autopilot.store) - 1, 0)
    in_auto = int(autopilot.mode == CopterMode.AUTO)
    return dialect.MAVLink_mission_current_message(seq, total, autopilot.mission.state, in_auto)


def autopilot_version(autopilot: Autopilot) -> Message:
    """AUTOPILOT_VERSION with the capabilities of the simulated firmware."""
    firmware = autopilot.faults.firmware
    major, minor, patch = firmware.version
    version = major << 24 | minor << 16 | patch << 8 | _IN_DEVELOPMENT
    return dialect.MAVLink_autopilot_version_message(
        firmware.capabilities, version, 0, 0, 0, list(b"builtin\0"), [0] * 8, [0] * 8, 0, 0, 0
    )


def home_position(autopilot: Autopilot) -> Message | None:
    """HOME_POSITION, once home is known."""
    home = autopilot.home
    if home is None:
        return None
    north_m, east_m, up_m = home.position_m
    return dialect.MAVLink_home_position_message(
        home.lat_e7, home.lon_e7, home.alt_cm * 10, north_m, east_m, -up_m, [float("nan")] * 4, 0, 0, 0
    )


def gps_global_origin(autopilot: Autopilot) -> Message | None:
    """GPS_GLOBAL_ORIGIN: where the EKF's local frame begins."""
    if not autopilot.sensors.origin_set:
        return None
    start = autopilot.start
    return dialect.MAVLink_gps_global_origin_message(start.lat_e7, start.lon_e7, start.alt_cm * 10)


def _extended_sys_state(autopilot: Autopilot) -> Message:
    flight = autopilot.flight
    if flight.landed:
        landed = dialect.MAV_LANDED_STATE_ON_GROUND
    elif flight.landing:
        landed = dialect.MAV_LANDED_STATE_LANDING
    else:
        in_air = dialect.MAV_LANDED_STATE_IN_AIR
        landed = dialect.MAV_LANDED_STATE_TAKEOFF if flight.taking_off else in_air
    return dialect.MAVLink_extended_sys_state_message(0, landed)


def _fence_status(autopilot: Autopilot) -> Message | None:
    return (
        None if not autopilot.parameters["FENCE_ENABLE"] else dialect.MAVLink_fence_status_message(0, 0, 0, 0)
    )


BUILDERS: dict[int, Builder] = {
    dialect.MAVLINK_MSG_ID_HEARTBEAT: heartbeat,
    dialect.MAVLINK_MSG_ID_SYS_STATUS: _sys_status,
    dialect.MAVLINK_MSG_ID_BATTERY_STATUS: _battery_status,
    dialect.MAVLINK_MSG_ID_MISSION_CURRENT: _mission_current,
    dialect.MAVLINK_MSG_ID_AUTOPILOT_VERSION: autopilot_version,
    dialect.MAVLINK_MSG_ID_HOME_POSITION: home_position,
    dialect.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: gps_global_origin,
    dialect.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: _extended_sys_state,
    dialect.MAVLINK_MSG_ID_FENCE_STATUS: _fence_status,
    **MOTION,
    **SENSORS,
}
"""Builders by message number: all that can be streamed or requested."""

"""What sensors and board report: GPS, EKF, RC, motors, and constants for the rest."""

from __future__ import annotations

import math
from collections.abc import Callable

from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.flight_parameters import wind_m_s

_UNKNOWN_DOP = 65535
_SATELLITES = 10
_RC_PWM = (1500, 1500, 1000, 1500, 1800, 1000, 1000, 1800)
_MOTOR_OFF, _MOTOR_IDLE, _MOTOR_SPAN = 1000, 1093, 1600


def _boot_us(autopilot: Autopilot) -> int:
    return int(autopilot.time_s * 1e6)


def _gps_raw_int(autopilot: Autopilot) -> Message:
    fix_type = autopilot.sensors.fix_type
    if fix_type < 2:
        dop, accuracy, satellites = (121, 300, 3) if fix_type else (_UNKNOWN_DOP, 0, 0)
        return dialect.MAVLink_gps_raw_int_message(
            0, fix_type, 0, 0, 0, dop, 200 if fix_type else _UNKNOWN_DOP, 0, 0, satellites,
            0, accuracy, accuracy,
        )  # fmt: skip
    location = autopilot.location
    north, east, _ = autopilot.flight.velocity_m_s
    course = round(math.degrees(math.atan2(east, north)) % 360 * 100) % 36000
    return dialect.MAVLink_gps_raw_int_message(
        _boot_us(autopilot), fix_type, location.lat_e7, location.lon_e7, location.alt_mm, 121, 200,
        round(math.hypot(north, east) * 100), course, _SATELLITES, location.alt_mm, 300, 300,
    )  # fmt: skip


def _ekf_status_report(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_ekf_status_report_message(autopilot.sensors.ekf_flags, 0, 0, 0, 0, 0)


def _system_time(autopilot: Autopilot) -> Message:
    unix_us = autopilot.unix_us if autopilot.sensors.fix_type >= 3 else 0
    return dialect.MAVLink_system_time_message(unix_us, autopilot.time_boot_ms)


def _motors(autopilot: Autopilot) -> list[int]:
    if not autopilot.armed:
        return [_MOTOR_OFF] * 4
    if autopilot.flight.landed:
        return [_MOTOR_IDLE] * 4
    return [round(_MOTOR_OFF + _MOTOR_SPAN * min(autopilot.flight.throttle, 0.6))] * 4


def _servo_output_raw(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_servo_output_raw_message(
        _boot_us(autopilot) & 0xFFFFFFFF, 0, *_motors(autopilot), 0, 0, 0, 0
    )


def _rc_channels(autopilot: Autopilot) -> Message:
    unused = (0,) * 10
    return dialect.MAVLink_rc_channels_message(autopilot.time_boot_ms, len(_RC_PWM), *_RC_PWM, *unused, 255)


def _rc_channels_raw(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_rc_channels_raw_message(autopilot.time_boot_ms, 0, *_RC_PWM, 255)


def _raw_imu(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_raw_imu_message(_boot_us(autopilot), *_inertial(autopilot), 0, 2504)


def _inertial(autopilot: Autopilot) -> tuple[int, ...]:
    """Accelerations mG, angular rates mrad/s and the magnetic field mGauss, of a copter in slow flight."""
    roll, pitch, _ = autopilot.flight.attitude_rad
    weight = (math.sin(pitch), -math.sin(roll) * math.cos(pitch), -math.cos(roll) * math.cos(pitch))
    rates = autopilot.flight.rates_rad_s
    return (*(round(1000 * part) for part in (*weight, *rates)), 224, 80, -528)


def _scaled_imu2(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_scaled_imu2_message(autopilot.time_boot_ms, *_inertial(autopilot), 2504)


def _scaled_imu3(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_scaled_imu3_message(autopilot.time_boot_ms, 0, 0, 0, *_inertial(autopilot)[3:], 0)


def _pressure_hpa(autopilot: Autopilot) -> float:
    """The standard atmosphere's pressure at the copter's height; none above 44 km."""
    return float(1013.25 * max(1 - 2.25577e-5 * autopilot.location.alt_mm / 1000, 0.0) ** 5.25588)


def _scaled_pressure(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_scaled_pressure_message(autopilot.time_boot_ms, _pressure_hpa(autopilot), 0, 2550)


def _scaled_pressure2(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_scaled_pressure2_message(autopilot.time_boot_ms, _pressure_hpa(autopilot), 0, 2550)


def _power_status(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_power_status_message(5000, 0, 0)


def _meminfo(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_meminfo_message(0, 65535, 131072)


def _ahrs(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_ahrs_message(0, 0, 0, 0, 0, 0.005, 0.005)


def _vibration(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_vibration_message(_boot_us(autopilot), 0.003, 0.003, 0.003, 0, 0, 0)


def _wind(autopilot: Autopilot) -> Message | None:
    """Direction that the wind comes from, its speed, and its speed downwards."""
    if not autopilot.sensors.position_ok:
        return None
    north, east, up = wind_m_s(autopilot.parameters, autopilot.flight.position_m[2])
    direction_deg = math.degrees(math.atan2(-east, -north))
    return dialect.MAVLink_wind_message(direction_deg, math.hypot(north, east, up), -up)


SENSORS: dict[int, Callable[[Autopilot], Message | None]] = {
    dialect.MAVLINK_MSG_ID_GPS_RAW_INT: _gps_raw_int,
    dialect.MAVLINK_MSG_ID_EKF_STATUS_REPORT: _ekf_status_report,
    dialect.MAVLINK_MSG_ID_SYSTEM_TIME: _system_time,
    dialect.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: _servo_output_raw,
    dialect.MAVLINK_MSG_ID_RC_CHANNELS: _rc_channels,
    dialect.MAVLINK_MSG_ID_RC_CHANNELS_RAW: _rc_channels_raw,
    dialect.MAVLINK_MSG_ID_RAW_IMU: _raw_imu,
    dialect.MAVLINK_MSG_ID_SCALED_IMU2: _scaled_imu2,
    dialect.MAVLINK_MSG_ID_SCALED_IMU3: _scaled_imu3,
    dialect.MAVLINK_MSG_ID_SCALED_PRESSURE: _scaled_pressure,
    dialect.MAVLINK_MSG_ID_SCALED_PRESSURE2: _scaled_pressure2,
    dialect.MAVLINK_MSG_ID_POWER_STATUS: _power_status,
    dialect.MAVLINK_MSG_ID_MEMINFO: _meminfo,
    dialect.MAVLINK_MSG_ID_AHRS: _ahrs,
    dialect.MAVLINK_MSG_ID_VIBRATION: _vibration,
    dialect.MAVLINK_MSG_ID_WIND: _wind,
}

"""The copter's position, motion and target as MAVLink messages."""

from __future__ import annotations

import math
from collections.abc import Callable

from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2
from flight_replay.simulator.flight.guided import GuidedTarget

# Everything but the position is to be ignored, and the reserved bits are set, as ArduCopter sends it.
_POSITION_ONLY = 65016
# Heading and yaw rate are to be ignored.
_NO_HEADING = 0b11 << 10


def _heading_deg(autopilot: Autopilot) -> float:
    return math.degrees(autopilot.flight.attitude_rad[2]) % 360.0


def _global_position_int(autopilot: Autopilot) -> Message:
    location = autopilot.location
    north, east, up = (round(speed * 100) for speed in autopilot.flight.velocity_m_s)
    heading = round(_heading_deg(autopilot) * 100) % 36000
    above_home_mm = location.alt_mm - (autopilot.home.alt_cm * 10 if autopilot.home else 0)
    if not autopilot.sensors.origin_set:
        return dialect.MAVLink_global_position_int_message(
            autopilot.time_boot_ms, 0, 0, 0, 0, 0, 0, 0, heading
        )
    return dialect.MAVLink_global_position_int_message(
        autopilot.time_boot_ms,
        location.lat_e7,
        location.lon_e7,
        location.alt_mm,
        above_home_mm,
        north,
        east,
        -up,
        heading,
    )


def _local_position_ned(autopilot: Autopilot) -> Message | None:
    if not autopilot.sensors.position_ok:
        return None
    north_m, east_m, up_m = autopilot.flight.position_m
    north_m_s, east_m_s, up_m_s = autopilot.flight.velocity_m_s
    return dialect.MAVLink_local_position_ned_message(
        autopilot.time_boot_ms, north_m, east_m, -up_m, north_m_s, east_m_s, -up_m_s
    )


def _attitude(autopilot: Autopilot) -> Message:
    return dialect.MAVLink_attitude_message(
        autopilot.time_boot_ms, *autopilot.flight.attitude_rad, *autopilot.flight.rates_rad_s
    )


def _attitude_quaternion(autopilot: Autopilot) -> Message:
    roll, pitch, yaw = (angle / 2 for angle in autopilot.flight.attitude_rad)
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return dialect.MAVLink_attitude_quaternion_message(
        autopilot.time_boot_ms,
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        *autopilot.flight.rates_rad_s,
    )


def _vfr_hud(autopilot: Autopilot) -> Message:
    north, east, up = autopilot.flight.velocity_m_s
    speed = math.hypot(north, east)
    throttle = int(autopilot.flight.throttle * 100) if autopilot.armed else 0
    airspeed = math.hypot(speed, up) if autopilot.sensors.position_ok else 0.0
    alt_m = autopilot.location.alt_mm / 1000 if autopilot.sensors.origin_set else 0.0
    return dialect.MAVLink_vfr_hud_message(airspeed, speed, int(_heading_deg(autopilot)), throttle, alt_m, up)


def _nav_controller_output(autopilot: Autopilot) -> Message:
    roll, pitch, yaw = (math.degrees(angle) for angle in autopilot.flight.attitude_rad)
    bearing_deg, distance_m = 0, 0.0
    target = autopilot.target_m
    if target is not None:
        north, east, _ = (a - b for a, b in zip(target, autopilot.flight.position_m, strict=True))
        distance_m = math.hypot(north, east)
        bearing_deg = int(math.degrees(math.atan2(east, north)) % 360)
    height_error_m = autopilot.flight.height_error_m
    return dialect.MAVLink_nav_controller_output_message(
        roll, pitch, int((yaw + 180) % 360 - 180), bearing_deg, min(int(distance_m), 65535),
        height_error_m, 0.0, 0.0,
    )  # fmt: skip


def _position_target_global_int(autopilot: Autopilot) -> Message | None:
    target = autopilot.target_m
    if target is None:
        return None
    location = autopilot.start.location_of(target)
    return dialect.MAVLink_position_target_global_int_message(
        autopilot.time_boot_ms, dialect.MAV_FRAME_GLOBAL, _POSITION_ONLY, location.lat_e7, location.lon_e7,
        location.alt_mm / 1000, 0, 0, 0, 0, 0, 0, 0, 0,
    )  # fmt: skip


def _position_target_local_ned(autopilot: Autopilot) -> Message | None:
    target = autopilot.target_m
    if target is None:
        return None
    goal = autopilot.flight.goal or GuidedTarget(position_m=target)
    groups = goal.position_m, goal.velocity_m_s, goal.acceleration_m_s2
    ignored = sum(0b111 << 3 * place for place, group in enumerate(groups) if group is None)
    values = [value for n, e, u in (group or (0.0, 0.0, 0.0) for group in groups) for value in (n, e, -u)]
    return dialect.MAVLink_position_target_local_ned_message(
        autopilot.time_boot_ms, dialect.MAV_FRAME_LOCAL_NED, _NO_HEADING | ignored, *values, 0, 0
    )


def _ahrs2(autopilot: Autopilot) -> Message | None:
    if not autopilot.sensors.attitude_ok:
        return None
    location = autopilot.location if autopilot.sensors.origin_set else None
    lat_e7, lon_e7, alt_m = (
        (location.lat_e7, location.lon_e7, location.alt_mm / 1000) if location else (0, 0, 0.0)
    )
    return dialect.MAVLink_ahrs2_message(*autopilot.flight.attitude_rad, alt_m, lat_e7, lon_e7)


def _simstate(autopilot: Autopilot) -> Message:
    location = autopilot.location
    return dialect.MAVLink_simstate_message(
        *autopilot.flight.attitude_rad, 0.0, 0.0, -GRAVITY_M_S2, *autopilot.flight.rates_rad_s,
        location.lat_e7, location.lon_e7,
    )  # fmt: skip


MOTION: dict[int, Callable[[Autopilot], Message | None]] = {
    dialect.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: _global_position_int,
    dialect.MAVLINK_MSG_ID_LOCAL_POSITION_NED: _local_position_ned,
    dialect.MAVLINK_MSG_ID_ATTITUDE: _attitude,
    dialect.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: _attitude_quaternion,
    dialect.MAVLINK_MSG_ID_VFR_HUD: _vfr_hud,
    dialect.MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT: _nav_controller_output,
    dialect.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT: _position_target_global_int,
    dialect.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: _position_target_local_ned,
    dialect.MAVLINK_MSG_ID_AHRS2: _ahrs2,
    dialect.MAVLINK_MSG_ID_SIMSTATE: _simstate,
}

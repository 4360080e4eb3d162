"""GUIDED: positions and velocities that stations send, in every form that ArduCopter takes.

Sources: ArduCopter/GCS_Mavlink.cpp (handle_message_set_position_target_*, do_reposition),
mode_auto.cpp (do_guided). Yaw and acceleration targets are ignored.
"""

from __future__ import annotations

import math

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.mission.stored_items import ItemRejected, to_stored_item
from flight_replay.simulator.protocol.channel import Sender
from flight_replay.simulator.protocol.command_int import ACCEPTED, DENIED, FAILED, CommandInt

_IGNORES_POSITION, _IGNORES_VELOCITY = 0b111, 0b111 << 3
_LOCAL, _LOCAL_OFFSET, _BODY, _BODY_OFFSET = 1, 7, 8, 9
_BODY_FRAMES = frozenset({_BODY, _BODY_OFFSET})
_OFFSET_FRAMES = frozenset({_LOCAL_OFFSET, _BODY, _BODY_OFFSET})
_CHANGE_MODE = 1  # MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
_MAX_VELOCITY_M_S = 1000.0


def item(autopilot: Autopilot, message: Message) -> int:
    """A mission item with current 2 (fly there) or 3 (change altitude); returns a MAV_MISSION_RESULT."""
    try:
        target = to_stored_item(message)
    except ItemRejected as refused:
        return refused.result
    position_m = autopilot.ekf_frame.position_of(target.lat_e7, target.lon_e7, target.alt_m, target.frame)
    if message.current == 3:
        if autopilot.mode == CopterMode.GUIDED and position_m is not None and not autopilot.flight.landed:
            north_m, east_m, _ = autopilot.flight.position_m
            _fly_to(autopilot, (north_m, east_m, position_m[2]))
        return int(dialect.MAV_MISSION_ACCEPTED)
    if (
        autopilot.mode != CopterMode.GUIDED
        or target.command != dialect.MAV_CMD_NAV_WAYPOINT
        or position_m is None
    ):
        return int(dialect.MAV_MISSION_ERROR)
    _fly_to(autopilot, position_m)
    return int(dialect.MAV_MISSION_ACCEPTED)


def _fly_to(autopilot: Autopilot, position_m: Vector) -> None:
    """Fly to a position, if the vehicle is in the air; on the ground the target is ignored."""
    if autopilot.armed and not autopilot.flight.landed:
        autopilot.flight.goto(position_m)


def reposition(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """DO_REPOSITION: fly to a location, entering GUIDED if asked to."""
    changes = int(command.params[1]) & _CHANGE_MODE
    if autopilot.mode != CopterMode.GUIDED and not changes:
        return DENIED
    position_m = autopilot.ekf_frame.position_of(command.x, command.y, command.z, command.frame)
    if position_m is None or (command.x == 0 and command.y == 0):
        return DENIED
    if not autopilot.request_mode(CopterMode.GUIDED):
        return FAILED
    _fly_to(autopilot, position_m)
    return ACCEPTED


def local_target(autopilot: Autopilot, message: Message, sender: Sender) -> bool:
    """SET_POSITION_TARGET_LOCAL_NED."""
    if autopilot.mode != CopterMode.GUIDED or autopilot.flight.landed:
        return True
    frame = message.coordinate_frame
    if frame not in {_LOCAL, *_OFFSET_FRAMES}:
        autopilot.flight.hold()
        return True
    position_m = (message.x, message.y, -message.z)
    velocity_m_s = (message.vx, message.vy, -message.vz)
    if frame in _BODY_FRAMES:
        position_m, velocity_m_s = (
            _body_to_local(autopilot, position_m),
            _body_to_local(autopilot, velocity_m_s),
        )
    if frame in _OFFSET_FRAMES:
        north_m, east_m, up_m = autopilot.flight.position_m
        position_m = (position_m[0] + north_m, position_m[1] + east_m, position_m[2] + up_m)
    _follow(autopilot, message.type_mask, position_m, velocity_m_s)
    return True


def _body_to_local(autopilot: Autopilot, vector: Vector) -> Vector:
    """A vector forward and right of the copter, as north and east."""
    yaw = autopilot.flight.attitude_rad[2]
    forward, right, up = vector
    return (
        forward * math.cos(yaw) - right * math.sin(yaw),
        forward * math.sin(yaw) + right * math.cos(yaw),
        up,
    )


def global_target(autopilot: Autopilot, message: Message, sender: Sender) -> bool:
    """SET_POSITION_TARGET_GLOBAL_INT."""
    if autopilot.mode != CopterMode.GUIDED or autopilot.flight.landed:
        return True
    position_m = autopilot.ekf_frame.position_of(
        message.lat_int, message.lon_int, message.alt, message.coordinate_frame
    )
    if position_m is None and not message.type_mask & _IGNORES_POSITION:
        autopilot.flight.hold()
    else:
        velocity_m_s = (message.vx, message.vy, -message.vz)
        _follow(autopilot, message.type_mask, position_m or (0.0, 0.0, 0.0), velocity_m_s)
    return True


def _follow(autopilot: Autopilot, mask: int, position_m: Vector, velocity_m_s: Vector) -> None:
    """Fly to the position, or at the velocity; anything else stops the vehicle."""
    if not mask & _IGNORES_POSITION and all(math.isfinite(part) for part in position_m):
        autopilot.flight.goto(position_m)
    elif mask & _IGNORES_POSITION and not mask & _IGNORES_VELOCITY and _is_plausible(velocity_m_s):
        autopilot.flight.fly_velocity(velocity_m_s)
    else:
        autopilot.flight.hold()


def _is_plausible(velocity_m_s: Vector) -> bool:
    return all(abs(part) <= _MAX_VELOCITY_M_S for part in velocity_m_s)

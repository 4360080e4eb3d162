"""GUIDED: targets of position, velocity, acceleration and heading that stations stream.

Source: ArduCopter/GCS_Mavlink.cpp (handle_message_set_position_target_local_ned, _global_int). A
target that makes no sense stops the copter; one outside the fence, or sent in another mode, is
dropped without a word, and so is what ArduCopter 3.3 does not understand.
"""

from __future__ import annotations

import math
from dataclasses import replace

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import Message
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.faults import GuidedSupport
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.guided import GuidedTarget
from flight_replay.simulator.protocol.channel import Sender

# POSITION_TARGET_TYPEMASK: one axis that is ignored ignores its group.
_POSITION, _VELOCITY, _ACCELERATION = 0b111, 0b111 << 3, 0b111 << 6
_FORCE, _YAW, _YAW_RATE = 1 << 9, 1 << 10, 1 << 11
# MAV_FRAMEs.
_LOCAL, _LOCAL_OFFSET, _BODY, _BODY_OFFSET = 1, 7, 8, 9
_BODY_FRAMES = frozenset({_BODY, _BODY_OFFSET})
_OFFSET_FRAMES = frozenset({_LOCAL_OFFSET, _BODY, _BODY_OFFSET})
_TERRAIN_FRAMES = frozenset({10, 11})
_MAX_VELOCITY_M_S = 1000.0
_ZERO: Vector = (0.0, 0.0, 0.0)


def local_target(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    """SET_POSITION_TARGET_LOCAL_NED."""
    if _is_ignored(autopilot, message):
        return
    frame = message.coordinate_frame
    if frame not in {_LOCAL, *_OFFSET_FRAMES}:
        _reject(autopilot)
        return
    target = _motion(message, autopilot)
    if not message.type_mask & _POSITION:
        target = replace(target, position_m=(message.x, message.y, -message.z))
    if frame in _BODY_FRAMES:
        target = _from_body(target, autopilot.flight.attitude_rad[2])
    if frame in _OFFSET_FRAMES and target.position_m is not None:
        (n, e, u), (here_n, here_e, here_u) = target.position_m, autopilot.flight.position_m
        target = replace(target, position_m=(n + here_n, e + here_e, u + here_u))
    _follow(autopilot, target)


def global_target(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    """SET_POSITION_TARGET_GLOBAL_INT: with position and velocity its acceleration is dropped."""
    if _is_ignored(autopilot, message):
        return
    target = _motion(message, autopilot)
    if not message.type_mask & _POSITION:
        frame = message.coordinate_frame
        position_m = autopilot.ekf_frame.position_of(message.lat_int, message.lon_int, message.alt, frame)
        moves = target.velocity_m_s is not None
        if position_m is None or (moves and frame in _TERRAIN_FRAMES):
            _reject(autopilot)
            return
        target = replace(target, position_m=position_m)
        if moves:
            target = replace(target, acceleration_m_s2=None)
    _follow(autopilot, target)


def _support(autopilot: Autopilot) -> GuidedSupport:
    return autopilot.faults.firmware.guided


def _is_ignored(autopilot: Autopilot, message: Message) -> bool:
    """Whether a target is for nothing: another mode, on the ground, or not understood."""
    if autopilot.mode != CopterMode.GUIDED or autopilot.flight.landed:
        return True
    accelerates = message.type_mask & _ACCELERATION == 0
    return accelerates and (bool(message.type_mask & _FORCE) or not _support(autopilot).acceleration)


def _motion(message: Message, autopilot: Autopilot) -> GuidedTarget:
    """What a target says besides its position."""
    mask, turns = message.type_mask, _support(autopilot).yaw
    return GuidedTarget(
        velocity_m_s=None if mask & _VELOCITY else (message.vx, message.vy, -message.vz),
        acceleration_m_s2=None if mask & _ACCELERATION else (message.afx, message.afy, -message.afz),
        yaw_rad=message.yaw if turns and not mask & _YAW else None,
        yaw_rate_rad_s=message.yaw_rate if turns and not mask & _YAW_RATE else None,
        yaw_is_relative=message.coordinate_frame in _BODY_FRAMES,
        keeps_heading=not turns,
    )


def _from_body(target: GuidedTarget, yaw: float) -> GuidedTarget:
    """A target forward and right of the copter, as north and east."""
    c, s = math.cos(yaw), math.sin(yaw)

    def turned(vector: Vector | None) -> Vector | None:
        if vector is None:
            return None
        forward, right, up = vector
        return forward * c - right * s, forward * s + right * c, up

    return replace(
        target,
        position_m=turned(target.position_m),
        velocity_m_s=turned(target.velocity_m_s),
        acceleration_m_s2=turned(target.acceleration_m_s2),
    )


def _follow(autopilot: Autopilot, target: GuidedTarget) -> None:
    """Follow a target that makes sense."""
    if not _makes_sense(target):
        _reject(autopilot)
    elif target.position_m is None or autopilot.allows_target(target.position_m):
        autopilot.flight.follow(target)
        if target.velocity_m_s is not None:
            autopilot.trigger("target")


def _makes_sense(target: GuidedTarget) -> bool:
    """Whether every number is one, and the velocity below 1,000 m/s."""
    vectors = (target.position_m or _ZERO, target.velocity_m_s or _ZERO, target.acceleration_m_s2 or _ZERO)
    turn = (target.yaw_rad or 0.0, target.yaw_rate_rad_s or 0.0)
    finite = all(map(math.isfinite, turn)) and all(all(map(math.isfinite, vector)) for vector in vectors)
    return finite and all(abs(part) <= _MAX_VELOCITY_M_S for part in target.velocity_m_s or _ZERO)


def _reject(autopilot: Autopilot) -> None:
    """Stop, as 4.6 does at a target that makes no sense; 3.3 does nothing."""
    if _support(autopilot).stops_at_nonsense:
        autopilot.flight.stop()

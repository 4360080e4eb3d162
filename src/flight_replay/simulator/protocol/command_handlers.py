"""What each command does; the answers are MAV_RESULT numbers."""

from __future__ import annotations

import math

from flight_replay.events import Severity
from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.modes import USER_TAKEOFF
from flight_replay.simulator.mission.stored_items import ALTITUDE_LIMIT_M
from flight_replay.simulator.protocol import banner, telemetry
from flight_replay.simulator.protocol.channel import Sender
from flight_replay.simulator.protocol.command_int import (
    ACCEPTED,
    DENIED,
    FAILED,
    TEMPORARILY_REJECTED,
    UNSUPPORTED,
    CommandHandler,
    CommandInt,
)

_FORCED_ARM, _FORCED_DISARM = 2989.0, 21196.0
_CUSTOM_MODE = dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED


def _result(succeeded: bool) -> int:
    return ACCEPTED if succeeded else FAILED


def always(result: int) -> CommandHandler:
    """What answers, and does nothing: ArduCopter denies the command, or it has no effect here."""
    return lambda autopilot, command, sender: result


def arm_disarm(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Arm or disarm; 2989 skips the arming checks, 21196 arms without them and disarms in flight."""
    wanted, force, *_ = command.params
    if wanted == 1:
        return _result(autopilot.arming.arm(forced=force in (_FORCED_ARM, _FORCED_DISARM)))
    if wanted != 0:
        return UNSUPPORTED
    if not autopilot.arming.may_disarm() and force != _FORCED_DISARM:
        return FAILED
    autopilot.disarm()
    return ACCEPTED


def set_mode(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Change to a custom mode."""
    if not int(command.params[0]) & _CUSTOM_MODE:
        return DENIED
    return _result(autopilot.request_mode(int(command.params[1])))


def takeoff(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Take off to an altitude above home: from the ground, armed, in a mode that allows it (takeoff.cpp)."""
    if command.frame != dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT:
        return DENIED
    above_home_m = autopilot.above_home_m
    if not autopilot.armed or not autopilot.flight.landed or not above_home_m < command.z < ALTITUDE_LIMIT_M:
        return FAILED
    if autopilot.mode not in USER_TAKEOFF or (
        autopilot.mode == CopterMode.ALT_HOLD and command.params[2] == 0
    ):
        return FAILED
    autopilot.flight.takeoff(command.z)
    autopilot.trigger("takeoff")
    return ACCEPTED


def mission_start(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Enter AUTO, and start the mission."""
    if not autopilot.request_mode(CopterMode.AUTO):
        return FAILED
    autopilot.mission.start()
    return ACCEPTED


def enter(mode: CopterMode) -> CommandHandler:
    """What enters a mode."""
    return lambda autopilot, command, sender: _result(autopilot.request_mode(mode))


def change_speed(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Change the horizontal, climb or descent speed, in modes that have one."""
    kind, speed_m_s, *_ = command.params
    if autopilot.mode not in (CopterMode.AUTO, CopterMode.GUIDED, CopterMode.RTL) or speed_m_s <= 0:
        return FAILED
    autopilot.flight.change_speed(max(int(kind + 0.1), 1), speed_m_s)
    return ACCEPTED


def condition_yaw(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Turn to a heading, or by an angle."""
    angle_deg, rate_deg_s, direction, relative = command.params
    if not 0 <= angle_deg <= 360 or relative not in (0, 1):
        return FAILED
    autopilot.flight.set_yaw(
        math.radians(angle_deg), math.radians(rate_deg_s), direction, relative=bool(relative)
    )
    return ACCEPTED


def set_roi(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Face a location from now on; 0 in all three ends that."""
    if command.x == 0 and command.y == 0 and command.z == 0:
        return end_roi(autopilot, command, sender)
    position_m = autopilot.ekf_frame.position_of(command.x, command.y, command.z, command.frame)
    if position_m is None:
        return DENIED
    autopilot.flight.face(position_m)
    return ACCEPTED


def end_roi(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Look along the path again."""
    autopilot.flight.face(None)
    return ACCEPTED


def set_home(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Move home here, or to a location."""
    if not autopilot.sensors.origin_set:
        return FAILED
    if command.params[0] == 1 or (command.x == 0 and command.y == 0):
        autopilot.move_home(autopilot.flight.position_m)
        return ACCEPTED
    if command.params[0] != 0:
        return FAILED
    position_m = autopilot.ekf_frame.position_of(command.x, command.y, command.z, command.frame)
    if position_m is None:
        return DENIED
    autopilot.move_home(position_m)
    return ACCEPTED


def get_home_position(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Send HOME_POSITION and GPS_GLOBAL_ORIGIN."""
    sent = [telemetry.home_position(autopilot), telemetry.gps_global_origin(autopilot)]
    for message in sent:
        if message is not None:
            sender.channel.send(message)
    return _result(sent[0] is not None)


def set_mission_current(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Make a mission item the current one."""
    seq = int(command.params[0])
    if not 0 <= seq < len(autopilot.store):
        return DENIED
    return _result(autopilot.mission.set_current(seq))


def reboot(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Reboot, when disarmed only."""
    if autopilot.armed:
        return FAILED
    if command.params[0] not in (1, 3):
        return UNSUPPORTED
    autopilot.reboot()
    return ACCEPTED


def run_prearm_checks(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Run the prearm checks, and report those that fail."""
    if autopilot.armed:
        return TEMPORARILY_REJECTED
    autopilot.prearm.report_problems()
    return ACCEPTED


def request_capabilities(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Send AUTOPILOT_VERSION."""
    if command.params[0] != 1:
        return FAILED
    sender.channel.send(telemetry.autopilot_version(autopilot))
    return ACCEPTED


def request_message(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Send one message once."""
    return _result(sender.channel.request(int(command.params[0])))


def set_message_interval(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Send a message at an interval, on this link."""
    number = int(command.params[0])
    if sender.channel.set_interval(number, int(command.params[1])):
        return ACCEPTED
    autopilot.say(Severity.INFO, f"No ap_message for mavlink id ({number})")
    return DENIED


def get_message_interval(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Send the interval of a message."""
    number = int(command.params[0])
    interval_us = sender.channel.interval_us(number)
    known = interval_us is not None
    sender.channel.send(dialect.MAVLink_message_interval_message(number & 0xFFFF, interval_us or 0))
    return _result(known)


def send_banner(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """Send the banner."""
    banner.send(autopilot, sender)
    return ACCEPTED

"""MAVLink commands, as COMMAND_LONG or COMMAND_INT, and what ArduCopter answers to them.

Sources: GCS_Common.cpp (handle_command_long, handle_command_int_packet), ArduCopter/GCS_Mavlink.cpp.
"""

from __future__ import annotations

import math

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.mission.stored_params import float32
from flight_replay.simulator.protocol import command_handlers, guided_positions
from flight_replay.simulator.protocol.channel import Sender
from flight_replay.simulator.protocol.command_int import (
    ACCEPTED,
    DENIED,
    UNSUPPORTED,
    CommandHandler,
    CommandInt,
)

_HAS_LOCATION = frozenset(
    {
        dialect.MAV_CMD_DO_SET_HOME,
        dialect.MAV_CMD_DO_REPOSITION,
        dialect.MAV_CMD_DO_SET_ROI,
        dialect.MAV_CMD_DO_SET_ROI_LOCATION,
    }
)


# Commands that ArduCopter takes as COMMAND_INT only.
_ONLY_INT = frozenset({dialect.MAV_CMD_DO_REPOSITION})
_MAX_INT_FLOAT = 2.0**31 - 128  # the largest 32-bit float that fits a 32-bit integer


def command_long(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    """Run a COMMAND_LONG; its locations are 32-bit floats."""
    number = message.command
    if number in _ONLY_INT:
        _acknowledge(sender, number, UNSUPPORTED)
        return
    scale = 1e7 if number in _HAS_LOCATION else 1.0
    x, y = (int(_number(part * scale)) for part in (message.param5, message.param6))
    frame = dialect.MAV_FRAME_GLOBAL
    if number == dialect.MAV_CMD_NAV_TAKEOFF:
        frame = dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT
    _answer(autopilot, CommandInt(number, _params(message), x, y, message.param7, frame), sender)


def command_int(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    """Run a COMMAND_INT."""
    command = CommandInt(message.command, _params(message), message.x, message.y, message.z, message.frame)
    _answer(autopilot, command, sender)


def _answer(autopilot: Autopilot, command: CommandInt, sender: Sender) -> None:
    handler = COMMANDS.get(command.number)
    result = UNSUPPORTED
    if handler is not None and command.number not in autopilot.faults.firmware.unknown_commands:
        result = handler(autopilot, command, sender)
    _acknowledge(sender, command.number, result)


def _acknowledge(sender: Sender, number: int, result: int) -> None:
    sender.channel.send(
        dialect.MAVLink_command_ack_message(number, result, 0, 0, sender.system, sender.component)
    )


def _params(message: Message) -> tuple[float, float, float, float]:
    return (
        _number(message.param1),
        _number(message.param2),
        _number(message.param3),
        _number(message.param4),
    )


def _number(value: float) -> float:
    """A parameter that can be made a whole number: NaN counts as 0."""
    return 0.0 if math.isnan(value) else float32(min(max(value, -_MAX_INT_FLOAT), _MAX_INT_FLOAT))


COMMANDS: dict[int, CommandHandler] = {
    dialect.MAV_CMD_COMPONENT_ARM_DISARM: command_handlers.arm_disarm,
    dialect.MAV_CMD_DO_SET_MODE: command_handlers.set_mode,
    dialect.MAV_CMD_NAV_TAKEOFF: command_handlers.takeoff,
    dialect.MAV_CMD_MISSION_START: command_handlers.mission_start,
    dialect.MAV_CMD_NAV_LOITER_UNLIM: command_handlers.enter(CopterMode.LOITER),
    dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH: command_handlers.enter(CopterMode.RTL),
    dialect.MAV_CMD_NAV_LAND: command_handlers.enter(CopterMode.LAND),
    dialect.MAV_CMD_DO_CHANGE_SPEED: command_handlers.change_speed,
    dialect.MAV_CMD_DO_REPOSITION: guided_positions.reposition,
    dialect.MAV_CMD_CONDITION_YAW: command_handlers.condition_yaw,
    dialect.MAV_CMD_DO_SET_HOME: command_handlers.set_home,
    dialect.MAV_CMD_GET_HOME_POSITION: command_handlers.get_home_position,
    dialect.MAV_CMD_DO_SET_MISSION_CURRENT: command_handlers.set_mission_current,
    dialect.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: command_handlers.reboot,
    dialect.MAV_CMD_PREFLIGHT_CALIBRATION: command_handlers.always(ACCEPTED),
    dialect.MAV_CMD_PREFLIGHT_STORAGE: command_handlers.always(DENIED),
    dialect.MAV_CMD_RUN_PREARM_CHECKS: command_handlers.run_prearm_checks,
    dialect.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: command_handlers.request_capabilities,
    dialect.MAV_CMD_REQUEST_MESSAGE: command_handlers.request_message,
    dialect.MAV_CMD_SET_MESSAGE_INTERVAL: command_handlers.set_message_interval,
    dialect.MAV_CMD_GET_MESSAGE_INTERVAL: command_handlers.get_message_interval,
    dialect.MAV_CMD_DO_SEND_BANNER: command_handlers.send_banner,
    dialect.MAV_CMD_DO_SET_ROI: command_handlers.set_roi,
    dialect.MAV_CMD_DO_SET_ROI_LOCATION: command_handlers.set_roi,
    dialect.MAV_CMD_DO_SET_ROI_NONE: command_handlers.end_roi,
}
"""Handlers by MAV_CMD; each returns a MAV_RESULT."""

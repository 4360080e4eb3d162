"""Handlers of the messages that are not the mission protocol's."""

from __future__ import annotations

import struct
from collections.abc import Callable

from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.protocol import banner, guided_targets, telemetry
from flight_replay.simulator.protocol.channel import Sender
from flight_replay.simulator.protocol.command_int import ACCEPTED, FAILED
from flight_replay.simulator.protocol.commands import command_int, command_long

MessageHandler = Callable[[Autopilot, Message, Sender], None]

# MAVLink FTP: opcode and error of a refusal, and the payload's size.
_FTP_NAK, _FTP_NOT_FOUND, _FTP_PAYLOAD = 129, 10, 251
_CUSTOM_MODE = dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED


def _heartbeat(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    if sender.system == autopilot.parameters["SYSID_MYGCS"]:
        autopilot.failsafes.gcs_heartbeat()


def _param_request_list(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    banner.send(autopilot, sender)
    sender.channel.send_parameters()


def _param_request_read(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    if message.param_index == -1:
        parameter = autopilot.parameters.find(message.param_id)
    else:
        parameter = autopilot.parameters.at(message.param_index)
    if parameter is not None:
        sender.channel.send_parameter(parameter, message.param_index & 0xFFFF)


def _param_set(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    value = float(message.param_value)
    if autopilot.parameters.find(message.param_id) is not None and abs(value) < float("inf"):
        autopilot.parameters.assign(message.param_id, value)


def _set_mode(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    entered = bool(message.base_mode & _CUSTOM_MODE) and autopilot.request_mode(message.custom_mode)
    if autopilot.faults.firmware.acks_set_mode:
        result = ACCEPTED if entered else FAILED
        sender.channel.send(dialect.MAVLink_command_ack_message(message.get_msgId(), result))


def _request_data_stream(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    if message.start_stop in (0, 1):
        rate_hz = message.req_message_rate if message.start_stop else 0
        sender.channel.set_stream_rate(message.req_stream_id, rate_hz)


def _mission_set_current(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    if autopilot.mission.set_current(message.seq):
        sender.channel.send(telemetry.mission_current(autopilot, message.seq))


def _ping(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    if message.target_system == 0:
        answer = dialect.MAVLink_ping_message(message.time_usec, message.seq, sender.system, sender.component)
        sender.channel.send(answer)


def _timesync(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    if message.tc1 == 0:
        sender.channel.send(dialect.MAVLink_timesync_message(int(autopilot.time_s * 1e9), message.ts1))


def _autopilot_version_request(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    sender.channel.send(telemetry.autopilot_version(autopilot))


def _file_transfer(autopilot: Autopilot, message: Message, sender: Sender) -> None:
    """Refuse: there are no files. A station that gets no answer waits for a timeout."""
    seq, session, opcode = struct.unpack_from("<HBB", bytes(message.payload))
    answer = struct.pack("<HBBBBBxIB", (seq + 1) % 2**16, session, _FTP_NAK, 1, opcode, 0, 0, _FTP_NOT_FOUND)
    payload = list(answer.ljust(_FTP_PAYLOAD, b"\0"))
    sender.channel.send(
        dialect.MAVLink_file_transfer_protocol_message(0, sender.system, sender.component, payload)
    )


HANDLERS: dict[str, MessageHandler] = {
    "HEARTBEAT": _heartbeat,
    "PARAM_REQUEST_LIST": _param_request_list,
    "PARAM_REQUEST_READ": _param_request_read,
    "PARAM_SET": _param_set,
    "SET_MODE": _set_mode,
    "COMMAND_LONG": command_long,
    "COMMAND_INT": command_int,
    "REQUEST_DATA_STREAM": _request_data_stream,
    "MISSION_SET_CURRENT": _mission_set_current,
    "SET_POSITION_TARGET_LOCAL_NED": guided_targets.local_target,
    "SET_POSITION_TARGET_GLOBAL_INT": guided_targets.global_target,
    "FILE_TRANSFER_PROTOCOL": _file_transfer,
    "PING": _ping,
    "TIMESYNC": _timesync,
    "AUTOPILOT_VERSION_REQUEST": _autopilot_version_request,
}
"""Handlers by message name."""

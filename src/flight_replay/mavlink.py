"""ArduPilot's MAVLink dialect, version 2, which ships no type information, and words for its results."""

from __future__ import annotations

from typing import Any

from pymavlink.dialects.v20 import ardupilotmega

dialect: Any = ardupilotmega
Message = Any

RESULTS = {
    number: entry.name.removeprefix("MAV_RESULT_").replace("_", " ").lower()
    for number, entry in dialect.enums["MAV_RESULT"].items()
}
"""Words for what a COMMAND_ACK answers."""
MISSION_RESULTS = {
    number: entry.name.removeprefix("MAV_MISSION_").replace("_", " ").lower()
    for number, entry in dialect.enums["MAV_MISSION_RESULT"].items()
}
"""Words for what a MISSION_ACK answers."""


def robust_parser() -> Any:
    """A parser that gives bytes that are no frame as a message of the type "BAD_DATA", and raises nothing."""
    parser = dialect.MAVLink(None)
    parser.robust_parsing = True
    return parser


def parsed(parser: Any, data: bytes) -> list[Message]:
    """The messages that ``data`` completes, "BAD_DATA" among them if the parser is robust.

    pymavlink keeps what it has parsed until nothing at all is left over: a sender whose pieces always end
    within a frame would fill the memory.
    """
    messages = parser.parse_buffer(data) or []
    del parser.buf[: parser.buf_index]
    parser.buf_index = 0
    return list(messages)


def source_of(message: Message) -> tuple[int, int]:
    """The system and component that sent a message."""
    return message.get_srcSystem(), message.get_srcComponent()

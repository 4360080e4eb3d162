"""ArduPilot's MAVLink dialect, version 2, which ships no type information; and who we are in it."""

from __future__ import annotations

from typing import Any

from pymavlink.dialects.v20 import ardupilotmega

dialect: Any = ardupilotmega
Message = Any

OUR_SYSTEM = 255
"""ArduPilot obeys, and counts as present, the ground station of SYSID_MYGCS, 255 unless changed."""
OUR_COMPONENT = 25
"""MAV_COMP_ID_USER1: unlike 190 and 230, not what ground stations on the same link use."""

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

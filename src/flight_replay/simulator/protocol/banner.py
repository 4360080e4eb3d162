"""The banner that a station gets when it connects."""

from __future__ import annotations

from flight_replay.events import Severity
from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.protocol.channel import Sender

# FRAME_CLASS and FRAME_TYPE.
_CLASSES = {1: "QUAD", 2: "HEXA", 3: "OCTA", 4: "OCTAQUAD", 7: "TRI"}
_TYPES = {0: "PLUS", 1: "X", 2: "V", 3: "H"}


def send(autopilot: Autopilot, sender: Sender) -> None:
    """Send firmware, what this really is, and the frame type to one station."""
    frame_class = _CLASSES.get(int(autopilot.parameters["FRAME_CLASS"]), "QUAD")
    frame_type = _TYPES.get(int(autopilot.parameters["FRAME_TYPE"]), "PLUS")
    for text in (
        f"{autopilot.faults.firmware.banner} (builtin)",
        "flight-replay's built-in copter, not ArduPilot",
        f"Frame: {frame_class}/{frame_type}",
    ):
        sender.channel.send(dialect.MAVLink_statustext_message(Severity.INFO, text.encode()))

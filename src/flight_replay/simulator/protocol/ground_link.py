"""MAVLink around one autopilot: messages in, answers and reports out, over any number of channels.

Messages come in decoded (``handle``), time passes only in ``step``. The autopilot knows nothing of
this: it reports what happens on board to its observers, of which this is one.
"""

from __future__ import annotations

from collections.abc import Callable

from flight_replay.events import Severity
from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.parameter_table import Parameter
from flight_replay.simulator.protocol import telemetry
from flight_replay.simulator.protocol.channel import LinkChannel, Sender
from flight_replay.simulator.protocol.dispatch import HANDLERS
from flight_replay.simulator.protocol.mission_protocol import MissionProtocol

_TEXT_LENGTH = 50
_NOT_REQUESTED = 65535  # PARAM_VALUE.param_index where nobody asked for the parameter


class GroundLink:
    """The ground stations' side of ``autopilot``; every station that is connected has a channel."""

    def __init__(self, autopilot: Autopilot) -> None:
        self.autopilot = autopilot
        self.channels: list[LinkChannel] = []
        self._missions = MissionProtocol(autopilot)
        self._texts: list[Message] = []
        self._long_texts = 0
        autopilot.observers.append(self)
        autopilot.parameters.on_change.append(self._parameter_changed)

    def open_channel(
        self, transmit: Callable[[bytes], None], has_room: Callable[[], bool] = lambda: True, number: int = 0
    ) -> LinkChannel:
        """Connect a station: ``transmit`` takes bytes, ``has_room`` says whether it takes more now.

        ``number`` chooses the SRn_* parameters that the stream rates start with.
        """
        channel = LinkChannel(self.autopilot, transmit, has_room, number)
        self.channels.append(channel)
        return channel

    def close_channel(self, channel: LinkChannel) -> None:
        """Disconnect a station."""
        self.channels.remove(channel)

    def step(self) -> None:
        """Let STEP_S seconds of the vehicle's time pass, and send what is due."""
        for text in self._texts:
            self._broadcast(text)
        self._texts.clear()
        self.autopilot.step()
        self._missions.update()
        for channel in list(self.channels):
            channel.step()

    def handle(self, message: Message, sender: Sender) -> None:
        """Act on a message addressed to this vehicle, or to everybody."""
        name = message.get_type()
        if name in self.autopilot.faults.firmware.unknown_messages:
            return
        handler = HANDLERS.get(name)
        if handler is not None:
            handler(self.autopilot, message, sender)
        elif name in self._missions.handlers:
            self._missions.handlers[name](message, sender)

    def _broadcast(self, message: Message | None) -> None:
        if message is not None:
            for channel in self.channels:
                channel.send(message)

    def _parameter_changed(self, parameter: Parameter) -> None:
        for channel in self.channels:
            channel.send_parameter(parameter, _NOT_REQUESTED)

    # what the autopilot reports

    def status_text(self, severity: Severity, text: str) -> None:
        """A STATUSTEXT to every station, behind the answers that are due now (GCS::service_statustext).

        A long one comes in chunks under a common number.
        """
        data = text.encode()
        is_long = len(data) > _TEXT_LENGTH
        if is_long:
            self._long_texts = self._long_texts % 65535 + 1
        number = self._long_texts if is_long else 0
        for chunk, begin in enumerate(range(0, len(data), _TEXT_LENGTH)):
            part = data[begin : begin + _TEXT_LENGTH]
            self._texts.append(dialect.MAVLink_statustext_message(severity, part, number, chunk))

    def home_changed(self) -> None:
        """GPS_GLOBAL_ORIGIN and HOME_POSITION to every station."""
        self._broadcast(telemetry.gps_global_origin(self.autopilot))
        self._broadcast(telemetry.home_position(self.autopilot))

    def mode_changed(self) -> None:
        """A HEARTBEAT with the new mode to every station."""
        self._broadcast(telemetry.heartbeat(self.autopilot))

    def item_reached(self, seq: int) -> None:
        """MISSION_ITEM_REACHED to every station."""
        self._broadcast(dialect.MAVLink_mission_item_reached_message(seq))

    def rebooted(self) -> None:
        """Forget transfers under way, and what the stations have asked for."""
        self._missions = MissionProtocol(self.autopilot)
        for channel in self.channels:
            channel.restart()

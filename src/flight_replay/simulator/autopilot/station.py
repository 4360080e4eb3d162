"""What the autopilot sees of a ground station: its channel, and who it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from flight_replay.simulator.autopilot.parameter_table import Parameter

from flight_replay.mavlink import Message


class Channel(Protocol):
    """What the autopilot sees of a link: a way to answer, and what was asked of that link alone."""

    mavlink1: bool

    def send(self, message: Message) -> None:
        """Queue a message for this link."""

    def send_parameters(self) -> None:
        """Begin to send the full parameter list."""

    def send_parameter(self, parameter: Parameter, index: int) -> None:
        """Send one parameter, under the index that was asked for (65535 if none was)."""

    def restart(self) -> None:
        """The autopilot was booted anew: forget what was asked for."""

    def set_stream_rate(self, stream: int, rate_hz: int) -> None:
        """Send the messages of a MAV_DATA_STREAM ``rate_hz`` times a second of vehicle time."""

    def set_interval(self, message_id: int, interval_us: int) -> bool:
        """Send one message every so many µs (-1 never, 0 as by default); False if it is unknown."""

    def interval_us(self, message_id: int) -> int | None:
        """The interval of a message, -1 when it is not sent, None when it is unknown."""

    def request(self, message_id: int) -> bool:
        """Send one message once; False if it is unknown."""


class Sender:
    """Where a message came from, and the way back."""

    __slots__ = ("channel", "component", "system")

    def __init__(self, channel: Channel, system: int, component: int) -> None:
        self.channel, self.system, self.component = channel, system, component

    def is_same_station(self, other: Sender) -> bool:
        """Whether both are one component of one system."""
        return (self.system, self.component) == (other.system, other.component)

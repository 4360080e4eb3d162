"""The vehicle's end of one link: bytes to messages and back, and what is streamed at which rate.

Like ArduPilot, a channel uses MAVLink 2 from the start, or MAVLink 1 if SERIAL0_PROTOCOL says so
(or the firmware is too old) until a MAVLink 2 message is received. No sockets and no clock here.
"""

from __future__ import annotations

from collections.abc import Callable

from flight_replay.mavlink import Message, dialect, parsed, robust_parser
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.parameter_table import Parameter
from flight_replay.simulator.flight.copter import STEP_S
from flight_replay.simulator.protocol.stream_rates import GROUPS, StreamRates
from flight_replay.simulator.protocol.telemetry import BUILDERS

# The parameter list is sent at this rate, by wall-clock time, so that a station's buffers keep up.
_PARAMETERS_PER_S = 2000
_STREAM_NAMES = {1: "RAW_SENS", 2: "EXT_STAT", 3: "RC_CHAN", 4: "RAW_CTRL", 6: "POSITION",
                 10: "EXTRA1", 11: "EXTRA2", 12: "EXTRA3"}  # fmt: skip
_MAVLINK1_PROTOCOL = 1
_LONGEST_INTERVAL_S = 65.535  # what ArduPilot's 16 bits of milliseconds hold
_LAST_MAVLINK1_ID = 255
_COMPONENT = 1


class LinkChannel:
    """A link to stations: ``transmit`` takes bytes, ``has_room`` says whether it would take more now."""

    def __init__(
        self,
        autopilot: Autopilot,
        transmit: Callable[[bytes], None],
        has_room: Callable[[], bool] = lambda: True,
        number: int = 0,
    ) -> None:
        self._autopilot, self._transmit, self._has_room = autopilot, transmit, has_room
        self._number = min(number, 4)
        self._decoder = robust_parser()
        self._encoder = dialect.MAVLink(None, srcComponent=_COMPONENT)
        self._only_mavlink1 = autopilot.faults.firmware.mavlink1
        protocol = autopilot.parameters["SERIAL0_PROTOCOL"]
        self.mavlink1 = self._only_mavlink1 or protocol == _MAVLINK1_PROTOCOL
        self.systems: set[int] = set()
        self.restart()

    def restart(self) -> None:
        """Reset after a boot: rates are those of SRn_* again, and no parameter list is being sent."""
        parameters = self._autopilot.parameters
        rates_hz = {stream: parameters[f"SR{self._number}_{name}"] for stream, name in _STREAM_NAMES.items()}
        self._rates = StreamRates(rates_hz)
        self._next_parameter: int | None = None
        self._other_heartbeats_due_s = 0.0

    # in

    def receive(self, data: bytes) -> list[tuple[Message, Sender]]:
        """The messages that have been received whole, with their senders; damaged ones are dropped."""
        found = []
        for message in parsed(self._decoder, data):
            if message.get_type() in ("BAD_DATA", "UNKNOWN"):
                continue
            if message.get_msgbuf()[0] == dialect.PROTOCOL_MARKER_V2 and not self._only_mavlink1:
                self.mavlink1 = False
            self.systems.add(message.get_srcSystem())
            found.append((message, Sender(self, message.get_srcSystem(), message.get_srcComponent())))
        return found

    # out

    def send(self, message: Message) -> None:
        """Encode a message from the vehicle, in the version that this link uses."""
        self._encoder.srcSystem = int(self._autopilot.parameters["SYSID_THISMAV"]) & 0xFF
        self._encoder.srcComponent = _COMPONENT
        self._send_as_is(message)

    def _send_as_is(self, message: Message) -> None:
        encoder = self._encoder
        if self.mavlink1:
            if message.get_msgId() > _LAST_MAVLINK1_ID:
                return
            message = _as_mavlink1(message)
        self._transmit(message.pack(encoder, force_mavlink1=self.mavlink1))
        encoder.seq = (encoder.seq + 1) % 256

    def forward(self, data: bytes) -> None:
        """Send on what another station sent."""
        self._transmit(data)

    def send_parameter(self, parameter: Parameter, index: int) -> None:
        """PARAM_VALUE of one parameter."""
        count = len(self._autopilot.parameters)
        name = parameter.name.encode()
        self.send(
            dialect.MAVLink_param_value_message(name, parameter.value, parameter.param_type, count, index)
        )

    def send_parameters(self) -> None:
        """Begin to send the full parameter list; a second request begins again."""
        self._next_parameter = 0

    def step(self) -> None:
        """Send what is due by the vehicle's clock; while the link has no room, telemetry is left out."""
        if not self._has_room():
            return
        for message_id in self._rates.due(self._autopilot.time_s):
            self.request(message_id)
        self._send_some_parameters()
        self._send_other_heartbeats()

    def _send_some_parameters(self) -> None:
        if self._next_parameter is None:
            return
        parameters = self._autopilot.parameters
        wall_s = STEP_S / max(parameters["SIM_SPEEDUP"], 1.0)
        for _ in range(max(1, round(_PARAMETERS_PER_S * wall_s))):
            parameter = parameters.at(self._next_parameter)
            if parameter is None:
                self._next_parameter = None
                return
            self.send_parameter(parameter, self._next_parameter)
            self._next_parameter += 1

    def _send_other_heartbeats(self) -> None:
        """Heartbeats, and positions, of the other systems that ``Faults`` puts on the link."""
        others = self._autopilot.faults.other_heartbeats
        if not others or self._autopilot.time_s < self._other_heartbeats_due_s:
            return
        self._other_heartbeats_due_s = self._autopilot.time_s + 1.0
        for other in others:
            self._encoder.srcSystem, self._encoder.srcComponent = other.system, other.component
            self._send_as_is(dialect.MAVLink_heartbeat_message(*other.fields, 3))
            if other.location is not None:
                lat_e7, lon_e7, up_mm = other.location
                self._send_as_is(
                    dialect.MAVLink_global_position_int_message(
                        self._autopilot.time_boot_ms, lat_e7, lon_e7, up_mm, up_mm, 0, 0, 0, 0
                    )
                )

    # rates

    def set_stream_rate(self, stream: int, rate_hz: int) -> None:
        """Send the messages of a MAV_DATA_STREAM ``rate_hz`` times per second of vehicle time."""
        if stream == dialect.MAV_DATA_STREAM_ALL or stream in GROUPS:
            self._rates.set_group(stream, rate_hz)

    def set_interval(self, message_id: int, interval_us: int) -> bool:
        """Send a message every so many µs; -1 stops it, 0 resets its rate; False if it is unknown."""
        if message_id not in BUILDERS:
            return False
        interval_s = min(interval_us / 1e6, _LONGEST_INTERVAL_S)
        self._rates.set_message(message_id, None if interval_us < 0 else interval_s)
        return True

    def interval_us(self, message_id: int) -> int | None:
        """A message's interval, -1 if it is not sent, None if it is unknown."""
        if message_id not in BUILDERS:
            return None
        interval_s = self._rates.interval_s(message_id)
        return -1 if interval_s is None else round(interval_s * 1e6)

    def request(self, message_id: int) -> bool:
        """Send a message once, now; False if it is unknown."""
        builder = BUILDERS.get(message_id)
        if builder is None:
            return False
        message = builder(self._autopilot)
        if message is not None and (message_id != _RC_CHANNELS_RAW or self.mavlink1):
            self.send(message)
        return True


class Sender:
    """Where a message came from, and the way back."""

    __slots__ = ("channel", "component", "system")

    def __init__(self, channel: LinkChannel, system: int, component: int) -> None:
        self.channel, self.system, self.component = channel, system, component

    def is_same_station(self, other: Sender) -> bool:
        """Whether both are one component of one system."""
        return (self.system, self.component) == (other.system, other.component)


_RC_CHANNELS_RAW = dialect.MAVLINK_MSG_ID_RC_CHANNELS_RAW


def _as_mavlink1(message: Message) -> Message:
    """The same message without the extension fields of MAVLink 2."""
    from pymavlink.dialects.v10 import ardupilotmega as version1

    kind = version1.mavlink_map[message.get_msgId()]
    # pymavlink keeps the bytes of text fields beside their decoded form, and packs only bytes.
    return kind(*[getattr(message, f"_{field}_raw", getattr(message, field)) for field in kind.fieldnames])

"""A ground station at the built-in copter's side, in vehicle time: no sockets, no waiting."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import dialect, robust_parser
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.autopilot.parameter_table import Parameters
from flight_replay.simulator.flight.copter import STEP_S
from flight_replay.simulator.protocol.ground_link import GroundLink

START = Start(47.397742, 8.545594, 488.0, 90.0)
READY_S = 10.0
GUIDED, AUTO, RTL = CopterMode.GUIDED, CopterMode.AUTO, CopterMode.RTL
LAND, LOITER = CopterMode.LAND, CopterMode.LOITER
ARM, SET_MODE, TAKEOFF, MISSION_START = 400, 176, 22, 300
ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4

Item = tuple[int, int, tuple[float, float, float, float], int, int, float]


def sim(faults: Faults | None = None, start: Start = START, **parameters: float) -> tuple[Autopilot, Station]:
    """A copter and a station 255/190 at it."""
    autopilot = Autopilot(start, parameters=Parameters(parameters) if parameters else None, faults=faults)
    return autopilot, Station(GroundLink(autopilot))


class Station:
    """Sends messages to the copter as bytes, and keeps what comes back."""

    def __init__(
        self, link: GroundLink, system: int = 255, component: int = 190, *, old: bool = False
    ) -> None:
        self.link, self.autopilot = link, link.autopilot
        self.received: list[Any] = []
        self._decoder = robust_parser()
        self.mav = dialect.MAVLink(None, system, component)
        self._old = old
        self.raw: list[bytes] = []
        self.channel = link.open_channel(self._hear)

    def _hear(self, data: bytes) -> None:
        self.raw.append(data)
        self.received += self._decoder.parse_buffer(data) or []

    def send(self, message: Any) -> None:
        """Send a message; the copter answers at once."""
        for received, sender in self.channel.receive(message.pack(self.mav, force_mavlink1=self._old)):
            self.link.handle(received, sender)

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
        """Let vehicle time pass, at most so much; whether the condition was met."""
        for _ in range(round(seconds / STEP_S)):
            if until():
                return True
            self.link.step()
        return until()

    # what was received

    def of(self, kind: str) -> list[Any]:
        """The messages of a kind, oldest first."""
        return [message for message in self.received if message.get_type() == kind]

    def last(self, kind: str) -> Any:
        """The latest message of a kind."""
        return self.of(kind)[-1]

    def reached(self) -> list[int]:
        """Items reported as reached."""
        return [message.seq for message in self.of("MISSION_ITEM_REACHED")]

    def order_of(self, count: int) -> list[str]:
        """The items begun, as spoken, until the last of ``count`` is reached."""
        self.run(300, lambda: f"Reached command #{count}" in self.texts)
        return [text.removeprefix("Mission: ") for text in self.texts if text.startswith("Mission: ")]

    @property
    def texts(self) -> list[str]:
        """Status texts, long ones put together again; those just spoken come with the next step."""
        self.link.step()
        whole: list[str] = []
        for message in self.of("STATUSTEXT"):
            if message.chunk_seq:
                whole[-1] += message.text
            else:
                whole.append(message.text)
        return whole

    def clear(self) -> None:
        """Drop what was received."""
        self.received.clear()

    # asking

    def command(self, number: int, *params: float) -> int:
        """A COMMAND_LONG, and the MAV_RESULT that answers it."""
        values = [*params, *([0.0] * (7 - len(params)))]
        self.send(dialect.MAVLink_command_long_message(1, 1, number, 0, *values))
        return int(self.last("COMMAND_ACK").result)

    def command_int(
        self, number: int, frame: int, params: Sequence[float], there: tuple[int, int, float]
    ) -> int:
        """A COMMAND_INT, and the MAV_RESULT that answers it."""
        x, y, z = there
        self.send(dialect.MAVLink_command_int_message(1, 1, frame, number, 0, 0, *params, x, y, z))
        return int(self.last("COMMAND_ACK").result)

    def mode(self, number: int) -> int:
        """Ask for a mode."""
        return self.command(SET_MODE, 1, number)

    def fly(self, up_m: float = 20.0) -> None:
        """Wait, arm in GUIDED and climb."""
        self.run(READY_S)
        assert self.mode(GUIDED) == 0
        assert self.command(ARM, 1) == 0
        assert self.command(TAKEOFF, 0, 0, 0, 0, 0, 0, up_m) == 0
        assert self.run(60, lambda: self.autopilot.above_home_m > 0.97 * up_m)

    def upload(self, items: Sequence[Item]) -> int:
        """Upload items behind home as MISSION_ITEM_INT, and the MAV_MISSION_RESULT that answers."""
        self.send(dialect.MAVLink_mission_count_message(1, 1, len(items) + 1))
        for seq, item in enumerate([item_at(0, 0), *items]):
            command, frame, params, x, y, z = item
            self.send(
                dialect.MAVLink_mission_item_int_message(1, 1, seq, frame, command, 0, 1, *params, x, y, z)
            )
        return int(self.last("MISSION_ACK").type)


def item_at(
    north_m: float, east_m: float, up_m: float = 20.0, *, command: int = 16, hold_s: float = 0.0
) -> Item:
    """An item so far north and east of START, above home."""
    there = START.location_of((north_m, east_m, 0.0))
    return command, 3, (hold_s, 0.0, 0.0, 0.0), there.lat_e7, there.lon_e7, up_m


def takeoff(up_m: float) -> Item:
    """A take-off item."""
    return 22, 3, (0.0, 0.0, 0.0, 0.0), 0, 0, up_m


def act(command: int, *params: float) -> Item:
    """An item without a location."""
    values = (*params, 0.0, 0.0, 0.0, 0.0)
    return command, 2, (values[0], values[1], values[2], values[3]), 0, 0, 0.0

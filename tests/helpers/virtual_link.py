"""A port to the built-in copter over a link that can lose, delay, double and mix frames, in virtual time."""

from __future__ import annotations

import heapq
import random
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from flight_replay.mavlink import dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.flight_model import STEP_S
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.autopilot.parameter_table import Parameters
from flight_replay.simulator.protocol.ground_link import GroundLink
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM
from flight_replay.vehicle.link.round_trip import RoundTrip
from flight_replay.vehicle.link.vehicle_link import is_for_us

START = Start(47.397742, 8.545594, 488.0, 90.0)


@dataclass(frozen=True)
class Weather:
    """What the link does to frames in each direction: shares of them, and seconds."""

    loss: float = 0.0
    delay_s: float = 0.002
    jitter_s: float = 0.0
    doubled: float = 0.0


class VirtualInbox:
    """Messages of chosen kinds; fetching lets time pass."""

    def __init__(self, port: VirtualLink, kinds: tuple[str, ...]) -> None:
        self._port, self.kinds = port, kinds
        self.messages: deque[Any] = deque()

    def get(self, timeout_s: float) -> Any:
        """The oldest message, letting time pass until it comes."""
        end_s = self._port.now_s() + max(timeout_s, 0.0)
        while not self.messages and self._port.now_s() < end_s:
            self._port.advance(end_s)
        return self.messages.popleft() if self.messages else None


class VirtualLink:
    """A ``Port``; the vehicle's time runs ``speedup`` times as fast as ``now_s``."""

    system, component = 1, 1

    def __init__(
        self,
        weather: Weather | None = None,
        faults: Faults | None = None,
        *,
        seed: int = 1,
        speedup: float = 1.0,
        start: Start = START,
        **parameters: float,
    ) -> None:
        self.weather = weather or Weather()
        self.speedup = speedup
        self.autopilot = Autopilot(
            start, parameters=Parameters(parameters) if parameters else None, faults=faults
        )
        self.ground_link = GroundLink(self.autopilot)
        self.channel = self.ground_link.open_channel(self._to_us)
        self.round_trip = RoundTrip()
        self.round_trip.measured(2 * self.weather.delay_s + self.weather.jitter_s + 0.005)
        self.sent: list[Any] = []
        self.heard: list[Any] = []
        self._mav = dialect.MAVLink(None, OUR_SYSTEM, OUR_COMPONENT)
        self._decoder = dialect.MAVLink(None)
        self._decoder.robust_parsing = True
        self._random = random.Random(seed)
        self._flying: list[tuple[float, int, bool, bytes]] = []
        self._count = 0
        self._now_s = self._step_s = 0.0
        self._inboxes: list[VirtualInbox] = []

    def now_s(self) -> float:
        return self._now_s

    def send(self, message: Any) -> None:
        self.sent.append(message)
        frame = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) % 256
        self._launch(True, frame)

    def _to_us(self, data: bytes) -> None:
        self._launch(False, data)

    def _launch(self, outward: bool, frame: bytes) -> None:
        weather = self.weather
        if self._random.random() < weather.loss:
            return
        for _ in range(1 + (self._random.random() < weather.doubled)):
            arrives_s = self._now_s + weather.delay_s + self._random.random() * weather.jitter_s
            self._count += 1
            heapq.heappush(self._flying, (arrives_s, self._count, outward, bytes(frame)))

    @contextmanager
    def inbox(self, *kinds: str) -> Iterator[VirtualInbox]:
        inbox = VirtualInbox(self, kinds)
        self._inboxes.append(inbox)
        try:
            yield inbox
        finally:
            self._inboxes.remove(inbox)

    def advance(self, end_s: float) -> None:
        """Go on to the next thing that happens, or to a time."""
        arrives_s = self._flying[0][0] if self._flying else float("inf")
        self._now_s = min(end_s, arrives_s, self._step_s)
        if self._now_s >= self._step_s:
            self._step_s += STEP_S / self.speedup
            self.ground_link.step()
        while self._flying and self._flying[0][0] <= self._now_s:
            _, _, outward, frame = heapq.heappop(self._flying)
            self._deliver(outward, frame)

    def _deliver(self, outward: bool, frame: bytes) -> None:
        if outward:
            for message, sender in self.channel.receive(frame):
                self.ground_link.handle(message, sender)
            return
        for message in self._decoder.parse_buffer(frame) or []:
            self.heard.append(message)
            for inbox in self._inboxes:
                if message.get_type() in inbox.kinds and is_for_us(message):
                    inbox.messages.append(message)

    def pass_time(self, seconds: float) -> None:
        """Let time pass."""
        end_s = self._now_s + seconds
        while self._now_s < end_s:
            self.advance(end_s)

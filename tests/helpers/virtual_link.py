"""A ``VehicleLink`` to the built-in copter in virtual time: loses, delays, duplicates and reorders frames."""

from __future__ import annotations

import heapq
import random
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from flight_replay.mavlink import dialect, robust_parser
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.autopilot.parameter_table import Parameters
from flight_replay.simulator.flight.copter import STEP_S
from flight_replay.simulator.protocol.ground_link import GroundLink
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM
from flight_replay.vehicle.link.round_trip import RoundTrip
from flight_replay.vehicle.link.vehicle_link import is_for_us
from tests.helpers.link_conditions import LinkConditions

START = Start(47.397742, 8.545594, 488.0, 90.0)


_MIN_DELAY_S = 0.002


class VirtualInbox:
    """Messages of chosen types; ``get`` advances the time until one comes."""

    def __init__(self, link: VirtualLink, types: tuple[str, ...]) -> None:
        self._link, self.types = link, types
        self.messages: deque[Any] = deque()

    def get(self, timeout_s: float) -> Any:
        """The oldest message; advances the time until it comes."""
        end_s = self._link.now_s() + max(timeout_s, 0.0)
        while not self.messages and self._link.now_s() < end_s:
            self._link.advance(end_s)
        return self.messages.popleft() if self.messages else None


class VirtualLink:
    """A ``VehicleLink``; the vehicle's clock runs ``speedup`` times as fast as ``now_s``."""

    system, component = 1, 1

    def __init__(
        self,
        conditions: LinkConditions | None = None,
        faults: Faults | None = None,
        *,
        seed: int = 1,
        speedup: float = 1.0,
        start: Start = START,
        **parameters: float,
    ) -> None:
        self.conditions = conditions or LinkConditions()
        self._delay_s = max(self.conditions.delay_s, _MIN_DELAY_S)
        self.speedup = speedup
        self.autopilot = Autopilot(
            start, parameters=Parameters(parameters) if parameters else None, faults=faults
        )
        self.ground_link = GroundLink(self.autopilot)
        self.channel = self.ground_link.open_channel(self._to_us)
        self.round_trip = RoundTrip()
        self.round_trip.measured(2 * self._delay_s + self.conditions.jitter_s + 0.005)
        self.sent: list[Any] = []
        self.received: list[Any] = []
        self._mav = dialect.MAVLink(None, OUR_SYSTEM, OUR_COMPONENT)
        self._decoder = robust_parser()
        self._random = random.Random(seed)
        self._in_flight: list[tuple[float, int, bool, bytes]] = []
        self._count = 0
        self._now_s = self._step_s = 0.0
        self._inboxes: list[VirtualInbox] = []

    def now_s(self) -> float:
        return self._now_s

    def send(self, message: Any) -> None:
        self.sent.append(message)
        frame = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) % 256
        self._schedule(True, frame)

    def _to_us(self, data: bytes) -> None:
        self._schedule(False, data)

    def _schedule(self, to_vehicle: bool, frame: bytes) -> None:
        conditions = self.conditions
        if self._random.random() < conditions.loss:
            return
        for _ in range(1 + (self._random.random() < conditions.duplicated)):
            arrives_s = self._now_s + self._delay_s + self._random.random() * conditions.jitter_s
            self._count += 1
            heapq.heappush(self._in_flight, (arrives_s, self._count, to_vehicle, bytes(frame)))

    @contextmanager
    def inbox(self, *types: str) -> Iterator[VirtualInbox]:
        inbox = VirtualInbox(self, types)
        self._inboxes.append(inbox)
        try:
            yield inbox
        finally:
            self._inboxes.remove(inbox)

    def advance(self, end_s: float) -> None:
        """Advance the time to the next event, or to ``end_s``."""
        arrives_s = self._in_flight[0][0] if self._in_flight else float("inf")
        self._now_s = min(end_s, arrives_s, self._step_s)
        if self._now_s >= self._step_s:
            self._step_s += STEP_S / self.speedup
            self.ground_link.step()
        while self._in_flight and self._in_flight[0][0] <= self._now_s:
            _, _, to_vehicle, frame = heapq.heappop(self._in_flight)
            self._deliver(to_vehicle, frame)

    def _deliver(self, to_vehicle: bool, frame: bytes) -> None:
        if to_vehicle:
            for message, sender in self.channel.receive(frame):
                self.ground_link.handle(message, sender)
            return
        for message in self._decoder.parse_buffer(frame) or []:
            self.received.append(message)
            if message.get_type() == "TIMESYNC":
                self.round_trip.answered(message, self._now_s)
            for inbox in self._inboxes:
                if message.get_type() in inbox.types and is_for_us(message):
                    inbox.messages.append(message)

    def pass_time(self, seconds: float) -> None:
        """Advance the time by ``seconds``."""
        end_s = self._now_s + seconds
        while self._now_s < end_s:
            self.advance(end_s)

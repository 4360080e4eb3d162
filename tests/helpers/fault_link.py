"""A TCP link between program and vehicle that can lose, delay, duplicate, reorder and corrupt MAVLink frames.

Every delivered frame is also kept, decoded, so that a test can check what the vehicle received; ``log``
has those of both directions in order, with whether each was to the vehicle. A ``Trigger`` waits for a
message to pass, and then acts on the link.
"""

from __future__ import annotations

import heapq
import random
import selectors
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from flight_replay.mavlink import dialect, robust_parser
from tests.helpers.link_conditions import LinkConditions

FOREVER_S = float("inf")
Message = Any


@dataclass
class Trigger:
    """Calls ``act`` the first ``times`` that ``matches`` is true of a message to or from the vehicle."""

    matches: Callable[[Message], bool]
    act: Callable[[FaultLink], None]
    times: int = 1


@dataclass
class _Direction:
    """One direction of a connection; ``rest`` is an incomplete frame."""

    source: socket.socket
    sink: socket.socket
    to_vehicle: bool
    rest: bytearray = field(default_factory=bytearray)
    decoder: Any = None


class FaultLink:
    """Listens on loopback, connects to the vehicle, and forwards frames under ``LinkConditions``."""

    def __init__(
        self,
        vehicle: str,
        conditions: LinkConditions | None = None,
        triggers: tuple[Trigger, ...] = (),
        seed: int = 1,
    ) -> None:
        """``vehicle`` is the ``tcp:`` connection string of the vehicle."""
        host, port = vehicle.split(":")[1:]
        self.conditions = conditions or LinkConditions()
        self.triggers = triggers
        self.to_vehicle: list[Message] = []
        self.from_vehicle: list[Message] = []
        self.log: list[tuple[bool, Message]] = []
        self._address = (host, int(port))
        self._random = random.Random(seed)
        self._cut_until_s = 0.0
        self._server = socket.create_server(("127.0.0.1", 0))
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._server, selectors.EVENT_READ, None)
        self._directions: list[_Direction] = []
        self._in_flight: list[tuple[float, int, _Direction, bytes]] = []
        self._count = 0
        self._another = dialect.MAVLink(None, srcSystem=254, srcComponent=190)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    @property
    def connection(self) -> str:
        """The connection string for the program."""
        return f"tcp:127.0.0.1:{self._server.getsockname()[1]}"

    def cut(self, seconds: float) -> None:
        """Drop all frames for ``seconds``."""
        self._cut_until_s = time.monotonic() + seconds

    def disconnect(self) -> None:
        """Close the connections; the program may reconnect."""
        for direction in self._directions:
            self._selector.unregister(direction.source)
            direction.source.close()
        self._directions.clear()

    def send_as_another(self, message: Message) -> None:
        """Let another ground station send the vehicle a message; from a ``Trigger`` only."""
        packed = message.pack(self._another)
        for direction in self._directions:
            if direction.to_vehicle:
                direction.sink.sendall(packed)

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        self._thread.join(5)
        self.disconnect()
        self._server.close()
        self._selector.close()

    def _run(self) -> None:
        while not self._stop.is_set():
            wait_s = self._in_flight[0][0] - time.monotonic() if self._in_flight else 0.05
            for key, _ in self._selector.select(min(max(wait_s, 0.0), 0.05)):
                if key.fileobj is self._server:
                    self._accept()
                elif key.data in self._directions:
                    self._read(key.data)
            while self._in_flight and self._in_flight[0][0] <= time.monotonic():
                _, _, direction, frame = heapq.heappop(self._in_flight)
                self._deliver(direction, frame)

    def _accept(self) -> None:
        program, _ = self._server.accept()
        try:
            vehicle = socket.create_connection(self._address, 1.0)
        except OSError:
            program.close()  # The vehicle is restarting.
            return
        for source, sink, to_vehicle in ((program, vehicle, True), (vehicle, program, False)):
            source.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            direction = _Direction(source, sink, to_vehicle, decoder=robust_parser())
            self._directions.append(direction)
            self._selector.register(source, selectors.EVENT_READ, direction)

    def _read(self, direction: _Direction) -> None:
        try:
            data = direction.source.recv(65536)
        except OSError:
            data = b""
        if not data:
            self.disconnect()
            return
        direction.rest += data
        for frame in _frames(direction.rest):
            self._schedule(direction, frame)

    def _schedule(self, direction: _Direction, frame: bytes) -> None:
        conditions = self.conditions
        for message in direction.decoder.parse_buffer(frame) or ():
            for trigger in self.triggers:
                if trigger.times and trigger.matches(message):
                    trigger.times -= 1
                    trigger.act(self)
        if time.monotonic() < self._cut_until_s or self._random.random() < conditions.loss:
            return
        if self._random.random() < conditions.corrupt:
            corrupted = bytearray(frame)
            corrupted[self._random.randrange(len(corrupted))] ^= 1 << self._random.randrange(8)
            frame = bytes(corrupted)
        for _ in range(1 + (self._random.random() < conditions.duplicated)):
            due_s = time.monotonic() + conditions.delay_s + conditions.jitter_s * self._random.random()
            self._count += 1
            heapq.heappush(self._in_flight, (due_s, self._count, direction, frame))

    def _deliver(self, direction: _Direction, frame: bytes) -> None:
        if direction not in self._directions:
            return
        try:
            direction.sink.sendall(frame)
        except OSError:
            self.disconnect()
            return
        kept = self.to_vehicle if direction.to_vehicle else self.from_vehicle
        messages = [m for m in robust_parser().parse_buffer(frame) or () if m.get_type() != "BAD_DATA"]
        kept += messages
        self.log += [(direction.to_vehicle, message) for message in messages]


def _frames(data: bytearray) -> Iterator[bytes]:
    """Remove whole frames, of either version, from the front of ``data``."""
    while len(data) >= 3:
        if data[0] == 0xFD:
            size = 12 + data[1] + (13 if data[2] & 1 else 0)
        elif data[0] == 0xFE:
            size = 8 + data[1]
        else:
            del data[0]
            continue
        if len(data) < size:
            return
        yield bytes(data[:size])
        del data[:size]


@contextmanager
def fault_link(
    vehicle: str, conditions: LinkConditions | None = None, triggers: tuple[Trigger, ...] = (), seed: int = 1
) -> Iterator[FaultLink]:
    """A link to ``vehicle`` for as long as the context lasts."""
    link = FaultLink(vehicle, conditions, triggers, seed)
    link.start()
    try:
        yield link
    finally:
        link.close()

"""A TCP link between program and vehicle that can lose, delay, double, mix, corrupt and cut MAVLink frames.

Everything that is delivered is also kept, decoded, so that a test can tell what the vehicle was
told and when. A ``Trip`` waits for a message to pass, and then does something to the link.
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

from pymavlink.dialects.v20 import ardupilotmega

FOREVER_S = float("inf")
Message = Any


@dataclass
class Weather:
    """Shares of frames, in each direction, and seconds."""

    loss: float = 0.0
    corrupt: float = 0.0
    doubled: float = 0.0
    delay_s: float = 0.0
    jitter_s: float = 0.0


@dataclass
class Trip:
    """When ``hit`` says so of a passing message (to the vehicle or from it), ``act`` once."""

    hit: Callable[[Message], bool]
    act: Callable[[FaultLink], None]
    done: bool = False


@dataclass
class _Side:
    """One direction: where frames come from, where they go, and what is left of the last bytes."""

    source: socket.socket
    sink: socket.socket
    outward: bool
    rest: bytearray = field(default_factory=bytearray)
    decoder: Any = None


class FaultLink:
    """Listens on loopback, connects on to the vehicle, and mistreats what passes."""

    def __init__(
        self, vehicle: str, weather: Weather | None = None, trips: tuple[Trip, ...] = (), seed: int = 1
    ) -> None:
        """``vehicle`` is the ``tcp:`` connection string of the real one."""
        host, port = vehicle.split(":")[1:]
        self.weather = weather or Weather()
        self.trips = trips
        self.to_vehicle: list[Message] = []
        self.from_vehicle: list[Message] = []
        self._address = (host, int(port))
        self._random = random.Random(seed)
        self._cut_until_s = 0.0
        self._server = socket.create_server(("127.0.0.1", 0))
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._server, selectors.EVENT_READ, None)
        self._sides: list[_Side] = []
        self._flying: list[tuple[float, int, _Side, bytes]] = []
        self._count = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    @property
    def connection(self) -> str:
        """Where the program connects to."""
        return f"tcp:127.0.0.1:{self._server.getsockname()[1]}"

    def cut(self, seconds: float) -> None:
        """Let nothing through for a while."""
        self._cut_until_s = time.monotonic() + seconds

    def hang_up(self) -> None:
        """Close the connections; the program may connect again."""
        for side in self._sides:
            self._selector.unregister(side.source)
            side.source.close()
        self._sides.clear()

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        self._thread.join(5)
        self.hang_up()
        self._server.close()
        self._selector.close()

    def _run(self) -> None:
        while not self._stop.is_set():
            wait_s = self._flying[0][0] - time.monotonic() if self._flying else 0.05
            for key, _ in self._selector.select(min(max(wait_s, 0.0), 0.05)):
                if key.fileobj is self._server:
                    self._accept()
                elif key.data in self._sides:
                    self._read(key.data)
            while self._flying and self._flying[0][0] <= time.monotonic():
                _, _, side, frame = heapq.heappop(self._flying)
                self._deliver(side, frame)

    def _accept(self) -> None:
        program, _ = self._server.accept()
        try:
            vehicle = socket.create_connection(self._address, 1.0)
        except OSError:
            program.close()  # The vehicle is restarting.
            return
        for source, sink, outward in ((program, vehicle, True), (vehicle, program, False)):
            source.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            side = _Side(source, sink, outward, decoder=ardupilotmega.MAVLink(None))
            side.decoder.robust_parsing = True
            self._sides.append(side)
            self._selector.register(source, selectors.EVENT_READ, side)

    def _read(self, side: _Side) -> None:
        try:
            data = side.source.recv(65536)
        except OSError:
            data = b""
        if not data:
            self.hang_up()
            return
        side.rest += data
        for frame in _frames(side.rest):
            self._launch(side, frame)

    def _launch(self, side: _Side, frame: bytes) -> None:
        weather = self.weather
        for message in side.decoder.parse_buffer(frame) or ():
            for trip in self.trips:
                if not trip.done and trip.hit(message):
                    trip.done = True
                    trip.act(self)
        if time.monotonic() < self._cut_until_s or self._random.random() < weather.loss:
            return
        if self._random.random() < weather.corrupt:
            spoilt = bytearray(frame)
            spoilt[self._random.randrange(len(spoilt))] ^= 1 << self._random.randrange(8)
            frame = bytes(spoilt)
        for _ in range(1 + (self._random.random() < weather.doubled)):
            due_s = time.monotonic() + weather.delay_s + weather.jitter_s * self._random.random()
            self._count += 1
            heapq.heappush(self._flying, (due_s, self._count, side, frame))

    def _deliver(self, side: _Side, frame: bytes) -> None:
        if side not in self._sides:
            return
        try:
            side.sink.sendall(frame)
        except OSError:
            self.hang_up()
            return
        decoder = ardupilotmega.MAVLink(None)
        decoder.robust_parsing = True
        kept = self.to_vehicle if side.outward else self.from_vehicle
        kept += [m for m in decoder.parse_buffer(frame) or () if m.get_type() != "BAD_DATA"]


def _frames(data: bytearray) -> Iterator[bytes]:
    """Take whole frames, of either version, off the front of a stream."""
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
    vehicle: str, weather: Weather | None = None, trips: tuple[Trip, ...] = (), seed: int = 1
) -> Iterator[FaultLink]:
    """A link to ``vehicle`` for as long as the context lasts."""
    link = FaultLink(vehicle, weather, trips, seed)
    link.start()
    try:
        yield link
    finally:
        link.close()

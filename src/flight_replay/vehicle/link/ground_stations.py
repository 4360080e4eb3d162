"""Ground stations that watch and may act: every frame of the vehicle goes out, every frame of theirs goes in.

Each station has a thread of its own and a queue that forgets the oldest frames, so that no station,
however slow or gone, holds up the flight or another station.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any, Protocol

from flight_replay.vehicle.link.ground_station_sockets import Socket, socket_for

_log = logging.getLogger(__name__)

QUEUED_FRAMES = 5000
"""Some ten seconds of a simulator at twenty times speed."""
_READ_S = 0.02
_REOPEN_S = 0.5
_CLOSE_S = 5.0

Message = Any
"""A decoded pymavlink message, which keeps the frame that it came in."""


class Link(Protocol):
    """The link to the vehicle, as far as stations need it."""

    def add_receiver(self, receiver: Callable[[Message], None]) -> None:
        """Hand every message that comes to ``receiver``."""

    def remove_receiver(self, receiver: Callable[[Message], None]) -> None:
        """Hand ``receiver`` no more messages."""

    def forward(self, frame: bytes) -> None:
        """Send a frame that somebody else made, as it is."""


@contextmanager
def ground_stations(link: Link, stations: Sequence[str]) -> Iterator[tuple[Station, ...]]:
    """Let the stations that ``--gcs`` names share the link for as long as the context lasts.

    Raises:
        FlightReplayError: A string cannot be understood.
    """
    made = tuple(Station(name, socket_for(name), link.forward) for name in stations)
    with ExitStack() as stack:
        for station in made:
            station.start()
            stack.callback(station.close)
            link.add_receiver(station.receive)
            stack.callback(link.remove_receiver, station.receive)
        yield made


class Station:
    """One ``--gcs``: frames queued for it, and a thread that carries them and what it answers."""

    def __init__(self, name: str, sockets: Socket, forward: Callable[[bytes], None]) -> None:
        self._name, self._sockets, self._forward = name, sockets, forward
        self._queue: deque[bytes] = deque(maxlen=QUEUED_FRAMES)
        self._parsers: dict[Hashable, Any] = {}
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"flight-replay gcs {name}", daemon=True)
        self.opened = threading.Event()

    def start(self) -> None:
        """Begin to carry frames."""
        self._thread.start()

    def receive(self, message: Message) -> None:
        """Queue the frame that a message of the vehicle came in."""
        self._queue.append(bytes(message.get_msgbuf()))

    def close(self) -> None:
        """Stop, once what is queued has been sent or the thread's patience ends."""
        self._stop.set()
        self._thread.join(_CLOSE_S)

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                self._carry()
            if self.opened.is_set():
                self._send_queued()
        except OSError as error:
            _log.debug("ground station %s: %s", self._name, error)
        finally:
            self._sockets.close()

    def _carry(self) -> None:
        """Send and hear once; a connection that broke is opened anew, after a while."""
        try:
            if not self.opened.is_set():
                self._sockets.open()
                self._parsers.clear()
                self.opened.set()
            self._send_queued()
            for source, data in self._sockets.read(_READ_S):
                self._hear(source, data)
        except OSError as error:
            _log.debug("ground station %s: %s", self._name, error)
            self.opened.clear()
            self._stop.wait(_REOPEN_S)

    def _send_queued(self) -> None:
        while self._queue:
            self._sockets.write(self._queue.popleft())

    def _hear(self, source: Hashable, data: bytes) -> None:
        """Forward whole frames only: bytes of two senders must not mix on the vehicle's link."""
        for message in self._parser(source).parse_buffer(data) or ():
            if message.get_type() != "BAD_DATA":
                self._forward(bytes(message.get_msgbuf()))

    def _parser(self, source: Hashable) -> Any:
        if source not in self._parsers:
            from pymavlink.dialects.v20 import ardupilotmega

            self._parsers[source] = ardupilotmega.MAVLink(None)
            self._parsers[source].robust_parsing = True
        return self._parsers[source]

"""Ground stations that share the link: every frame of the vehicle goes to them, and theirs to the vehicle.

Each station has its own thread and a queue that drops the oldest frames, so that no station, however
slow or absent, delays the flight or another station.
"""

from __future__ import annotations

import logging
import threading
from collections import OrderedDict, deque
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import Protocol

from flight_replay.mavlink import Message
from flight_replay.vehicle.link.admission import Admission, NotMavlinkError
from flight_replay.vehicle.link.frame_parser import MAX_SENDERS
from flight_replay.vehicle.link.ground_station_sockets import GroundStationSocket, socket_for

_log = logging.getLogger(__name__)

QUEUED_FRAMES = 5000
"""Some ten seconds of a simulator at twenty times speed."""
_READ_S = 0.02
_REOPEN_S = 0.5
_CLOSE_S = 5.0


class SharedLink(Protocol):
    """The link to the vehicle, as far as ground stations need it."""

    def add_receiver(self, receiver: Callable[[Message], None]) -> None:
        """Call ``receiver`` with every message received."""

    def remove_receiver(self, receiver: Callable[[Message], None]) -> None:
        """Call ``receiver`` no longer."""

    def forward(self, frame: bytes) -> None:
        """Send a frame, unchanged."""


@contextmanager
def ground_stations(
    link: SharedLink, addresses: Sequence[str], *, allow_open: bool = False
) -> Iterator[tuple[GroundStation, ...]]:
    """Share the link with the ground stations that ``--gcs`` names, for as long as the context lasts.

    ``allow_open`` lets them listen on other addresses than loopback.

    Raises:
        FlightReplayError: An address is invalid.
    """
    sockets = [socket_for(address, allow_open=allow_open) for address in addresses]
    stations = tuple(
        GroundStation(name, socket, link.forward) for name, socket in zip(addresses, sockets, strict=True)
    )
    with ExitStack() as stack:
        for station in stations:
            station.start()
            stack.callback(station.close)
            link.add_receiver(station.receive)
            stack.callback(link.remove_receiver, station.receive)
        yield stations


class GroundStation:
    """One ``--gcs``: frames queued for it, and a thread that sends them and forwards its own."""

    def __init__(self, name: str, sockets: GroundStationSocket, forward: Callable[[bytes], None]) -> None:
        self._name, self._sockets, self._forward = name, sockets, forward
        self._queue: deque[bytes] = deque(maxlen=QUEUED_FRAMES)
        self._admissions: OrderedDict[Hashable, Admission] = OrderedDict()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"flight-replay gcs {name}", daemon=True)
        self.opened = threading.Event()

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def receive(self, message: Message) -> None:
        """Queue the frame of a message of the vehicle."""
        self._queue.append(bytes(message.get_msgbuf()))

    def close(self) -> None:
        """Stop the thread, after it has sent what is queued or reached its time limit."""
        self._stop.set()
        self._thread.join(_CLOSE_S)

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                self._exchange()
            if self.opened.is_set():
                self._send_queued()
        except OSError as error:
            _log.debug("ground station %s: %s", self._name, error)
        finally:
            self._sockets.close()

    def _exchange(self) -> None:
        """Send and receive once; a broken connection is reopened after a pause."""
        try:
            if not self.opened.is_set():
                self._sockets.open()
                self._admissions.clear()
                self.opened.set()
            self._send_queued()
            for source, data in self._sockets.read(_READ_S):
                self._forward_frames(source, data)
        except Exception as error:
            # Whatever it is, the station is reopened: this thread must not end in flight.
            _log.debug("ground station %s: %s", self._name, error)
            self.opened.clear()
            self._stop.wait(_REOPEN_S)

    def _send_queued(self) -> None:
        while self._queue:
            self._sockets.write(self._queue.popleft())

    def _forward_frames(self, source: Hashable, data: bytes) -> None:
        """Forward whole frames only: bytes of two senders must not mix on the vehicle's link."""
        admission = self._admissions.pop(source, None) or Admission(admitted=not self._sockets.listens)
        if not data:
            return
        try:
            frames = list(admission.frames(data))
        except NotMavlinkError:
            _log.warning("a sender at ground station port %s does not speak MAVLink: dropped", self._name)
            self._sockets.drop(source)
            return
        self._admissions[source] = admission
        while len(self._admissions) > MAX_SENDERS:
            self._admissions.popitem(last=False)
        if admission.admitted:
            self._sockets.admit(source)
        for frame in frames:
            self._forward(frame)

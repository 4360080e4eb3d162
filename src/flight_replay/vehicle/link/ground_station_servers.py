"""Servers that ground stations connect to: a few at a time, each known by its connection or address."""

from __future__ import annotations

import logging
import select
import socket
import time
from collections.abc import Hashable
from contextlib import suppress

from flight_replay.vehicle.link.host_lookup import look_up
from flight_replay.vehicle.link.udp_peers import UdpPeers

_log = logging.getLogger(__name__)

_CHUNK = 65536
_LOOK_UP_S = 4.0
MAX_CONNECTIONS = 8
_RETRY_ACCEPT_S = 0.5
_SEND_S = 2.0
"""How long sending to a station may block: a station that blocks longer is disconnected."""

Address = tuple[str, int]
Received = list[tuple[Hashable, bytes]]
"""(sender, data)."""


class UdpServer:
    """UDP that any number of stations send to; those that are admitted are sent every frame."""

    listens = True

    def __init__(self, address: Address) -> None:
        self._address = address
        self._socket: socket.socket | None = None
        self._peers = UdpPeers()

    def open(self) -> None:
        """Listen at the address."""
        self.close()
        family, kind, _, _, address = look_up(*self._address, _LOOK_UP_S, socket.SOCK_DGRAM)[0]
        self._socket = socket.socket(family, kind)
        self._socket.bind(address)

    def read(self, timeout_s: float) -> Received:
        """One datagram and its sender."""
        if self._socket is None:
            raise OSError("the socket is closed")
        if not select.select([self._socket], [], [], timeout_s)[0]:
            return []
        try:
            data, sender = self._socket.recvfrom(_CHUNK)
        except ConnectionError:
            return []  # An earlier datagram was refused: that station is gone.
        return [(sender, data)]

    def admit(self, source: Hashable) -> None:
        """Send frames to this station, until it is silent for long."""
        self._peers.received(source, time.monotonic())

    def drop(self, source: Hashable) -> None:
        """Nothing was sent to it, and nothing will be."""

    def write(self, frame: bytes) -> None:
        """Send to every station that is admitted."""
        for address in self._peers.addresses:
            if self._socket is not None:
                with suppress(OSError):
                    self._socket.sendto(frame, address)

    def close(self) -> None:
        """Close; no effect when closed."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class TcpServer:
    """A TCP server that a few ground stations connect to."""

    listens = True

    def __init__(self, address: Address) -> None:
        self._address = address
        self._accept_after_s = 0.0
        self._listener: socket.socket | None = None
        self._stations: list[socket.socket] = []

    @property
    def port(self) -> int:
        """The port that stations connect to, once open."""
        return int(self._open_listener.getsockname()[1])

    @property
    def _open_listener(self) -> socket.socket:
        if self._listener is None:
            raise OSError("the socket is closed")
        return self._listener

    def open(self) -> None:
        """Listen."""
        self.close()
        family, _, _, _, address = look_up(*self._address, _LOOK_UP_S)[0]
        self._listener = socket.create_server(address[:2], family=family)

    def read(self, timeout_s: float) -> Received:
        """Data of each station; accepts new stations, and drops those that closed the connection."""
        received: Received = []
        # A connection that cannot be accepted stays ready, and would keep this thread busy.
        accepting = [self._open_listener] if time.monotonic() >= self._accept_after_s else []
        for ready in select.select([*accepting, *self._stations], [], [], timeout_s)[0]:
            if ready is self._listener:
                self._accept()
                continue
            data = b""
            with suppress(OSError):
                data = ready.recv(_CHUNK)
            received.append((ready, data))
            if not data:
                self._disconnect(ready)
        return received

    def _accept(self) -> None:
        try:
            station, _ = self._open_listener.accept()
        except OSError as error:
            # Out of descriptors, say: those that are connected must not suffer.
            _log.warning("cannot accept a ground station: %s", error)
            self._accept_after_s = time.monotonic() + _RETRY_ACCEPT_S
            return
        if len(self._stations) >= MAX_CONNECTIONS:
            _log.warning("%d ground stations are connected already", MAX_CONNECTIONS)
            station.close()
            return
        station.settimeout(_SEND_S)
        self._stations.append(station)

    def admit(self, source: Hashable) -> None:
        """It is connected, which is enough to be sent frames."""

    def drop(self, source: Hashable) -> None:
        """Disconnect this sender."""
        if isinstance(source, socket.socket):
            self._disconnect(source)

    def write(self, frame: bytes) -> None:
        """Send to all that are connected; a station that does not receive is dropped."""
        for station in list(self._stations):
            try:
                station.sendall(frame)
            except OSError:
                self._disconnect(station)

    def _disconnect(self, station: socket.socket) -> None:
        if station in self._stations:
            self._stations.remove(station)
        station.close()

    def close(self) -> None:
        """Close, with every connection; no effect when closed."""
        for station in list(self._stations):
            self._disconnect(station)
        if self._listener is not None:
            self._listener.close()
            self._listener = None

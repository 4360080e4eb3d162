"""Sockets to ground stations: bytes out to all who are there, bytes in with who sent them.

``udp:HOST:PORT`` (or ``udpout:``) speaks to a station that listens; ``udpin:HOST:PORT`` waits to be
spoken to; ``tcp:HOST:PORT`` connects to a station that listens; ``tcpin:HOST:PORT`` lets stations connect.
"""

from __future__ import annotations

import select
import socket
from collections.abc import Hashable
from contextlib import suppress
from typing import Any, Protocol

from flight_replay.errors import FlightReplayError

_CHUNK = 65536
_PATIENCE_S = 2.0
"""How long a stream may block: a station that hangs longer is dropped, it must not hold anything up."""

Heard = list[tuple[Hashable, bytes]]
"""Who sent, and what."""


class Socket(Protocol):
    """A way to ground stations; ``OSError`` tells that it broke and must be opened again."""

    def open(self) -> None:
        """Open, or open again."""

    def read(self, timeout_s: float) -> Heard:
        """What has come, as soon as something has; nothing after the timeout."""

    def write(self, frame: bytes) -> None:
        """Send a frame to all who are there."""

    def close(self) -> None:
        """Close; harmless when closed."""


def socket_for(station: str) -> Socket:
    """The socket that a ``--gcs`` string names.

    Raises:
        FlightReplayError: The string cannot be understood.
    """
    kind, _, address = station.partition(":")
    make = _KINDS.get(kind.lower())
    host, _, port = address.rpartition(":")
    if make is None or not host or not port.isdigit() or not 0 <= int(port) < 65536:
        raise FlightReplayError(
            f"cannot understand the ground station {station!r}; write udp:HOST:PORT, udpin:HOST:PORT, "
            "tcp:HOST:PORT or tcpin:HOST:PORT"
        )
    return make(host.strip("[]"), int(port))


class _Addressed:
    """What all sockets share: an address, and being open or not."""

    def __init__(self, host: str, port: int) -> None:
        self._address = (host, port)
        self._socket: socket.socket | None = None

    @property
    def port(self) -> int:
        """The port at this end, once open."""
        return int(self._opened.getsockname()[1])

    @property
    def _opened(self) -> socket.socket:
        if self._socket is None:
            raise OSError("the socket is closed")
        return self._socket

    def _made(self, kind: socket.SocketKind) -> tuple[socket.socket, Any]:
        """A new socket of the address's family, and the address in that family's form."""
        self.close()
        family, _, _, _, address = socket.getaddrinfo(*self._address, type=kind)[0]
        self._socket = socket.socket(family, kind)
        return self._socket, address

    def close(self) -> None:
        """Close; harmless when closed."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _readable(sockets: list[socket.socket], timeout_s: float) -> list[socket.socket]:
    return select.select(sockets, [], [], timeout_s)[0]


class UdpOut(_Addressed):
    """Datagrams to one station that listens; only its answers are heard."""

    def open(self) -> None:
        """Make ready to speak."""
        made, address = self._made(socket.SOCK_DGRAM)
        made.connect(address)

    def read(self, timeout_s: float) -> Heard:
        """One datagram."""
        if not _readable([self._opened], timeout_s):
            return []
        # The station may not have been started yet, or no longer be there: that is its affair.
        with suppress(ConnectionError):
            return [(None, self._opened.recv(_CHUNK))]
        return []

    def write(self, frame: bytes) -> None:
        """Send, whether somebody listens or not."""
        with suppress(ConnectionError):
            self._opened.send(frame)


class UdpIn(_Addressed):
    """Datagrams to every station that has spoken to this port."""

    def open(self) -> None:
        """Listen."""
        self._stations: set[Any] = set()
        made, address = self._made(socket.SOCK_DGRAM)
        made.bind(address)

    def read(self, timeout_s: float) -> Heard:
        """One datagram."""
        if not _readable([self._opened], timeout_s):
            return []
        with suppress(ConnectionError):
            data, sender = self._opened.recvfrom(_CHUNK)
            self._stations.add(sender)
            return [(sender, data)]
        return []

    def write(self, frame: bytes) -> None:
        """Send to all who were heard."""
        for station in self._stations:
            self._opened.sendto(frame, station)


class TcpOut(_Addressed):
    """A stream to a station that listens."""

    def open(self) -> None:
        """Connect, in seconds at most."""
        self.close()
        self._socket = socket.create_connection(self._address, _PATIENCE_S)

    def read(self, timeout_s: float) -> Heard:
        """What has come; the stream's end is an error."""
        if not _readable([self._opened], timeout_s):
            return []
        data = self._opened.recv(_CHUNK)
        if not data:
            raise ConnectionResetError("the station closed the connection")
        return [(self._opened, data)]

    def write(self, frame: bytes) -> None:
        """Send all of it, in seconds at most."""
        self._opened.sendall(frame)


class TcpIn(_Addressed):
    """Streams to every station that connects."""

    def __init__(self, host: str, port: int) -> None:
        super().__init__(host, port)
        self._stations: list[socket.socket] = []

    def open(self) -> None:
        """Listen."""
        made, address = self._made(socket.SOCK_STREAM)
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind(address)
        made.listen()

    def read(self, timeout_s: float) -> Heard:
        """What has come from each station; new ones are let in, those that left are forgotten."""
        heard: Heard = []
        for ready in _readable([self._opened, *self._stations], timeout_s):
            if ready is self._opened:
                station, _ = ready.accept()
                station.settimeout(_PATIENCE_S)
                self._stations.append(station)
                continue
            data = b""
            with suppress(OSError):
                data = ready.recv(_CHUNK)
            if data:
                heard.append((ready, data))
            else:
                self._drop(ready)
        return heard

    def write(self, frame: bytes) -> None:
        """Send to all who are connected; who does not take it is dropped."""
        for station in list(self._stations):
            try:
                station.sendall(frame)
            except OSError:
                self._drop(station)

    def _drop(self, station: socket.socket) -> None:
        self._stations.remove(station)
        station.close()

    def close(self) -> None:
        """Close, with every stream; harmless when closed."""
        for station in list(self._stations):
            self._drop(station)
        super().close()


_KINDS: dict[str, type[UdpOut] | type[UdpIn] | type[TcpOut] | type[TcpIn]] = {
    "udp": UdpOut,
    "udpout": UdpOut,
    "udpin": UdpIn,
    "tcp": TcpOut,
    "tcpin": TcpIn,
}

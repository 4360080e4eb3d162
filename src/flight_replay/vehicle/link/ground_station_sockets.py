"""Sockets to ground stations: bytes out to all who are there, bytes in with who sent them.

``udp:HOST:PORT`` (or ``udpout:``) speaks to a station that listens; ``udpin:HOST:PORT`` waits to be
spoken to; ``tcp:HOST:PORT`` connects to a station that listens; ``tcpin:HOST:PORT`` lets stations connect.
"""

from __future__ import annotations

import select
import socket
from collections.abc import Hashable
from contextlib import suppress
from typing import Protocol

from flight_replay.errors import FlightReplayError
from flight_replay.vehicle.link.transport import TcpClient, Transport, UdpClient, UdpListener

_CHUNK = 65536
_PATIENCE_S = 2.0
"""How long a stream may block: a station that hangs longer is dropped, it must not hold anything up."""

Address = tuple[str, int]
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
    kind, _, rest = station.partition(":")
    host, _, port = rest.rpartition(":")
    address = (host.strip("[]"), int(port) if port.isdigit() else -1)
    if kind.lower() in _KINDS and host and 0 < address[1] < 65536:
        return OneStream(_KINDS[kind.lower()](address))
    if kind.lower() == "tcpin" and host and 0 <= address[1] < 65536:
        return TcpIn(address)
    raise FlightReplayError(
        f"cannot understand the ground station {station!r}; write udp:HOST:PORT, udpin:HOST:PORT, "
        "tcp:HOST:PORT or tcpin:HOST:PORT"
    )


_KINDS: dict[str, type[UdpClient] | type[UdpListener] | type[TcpClient]] = {
    "udp": UdpClient,
    "udpout": UdpClient,
    "udpin": UdpListener,
    "tcp": TcpClient,
}


class OneStream:
    """A transport as to a vehicle: one stream of bytes, or datagrams that each hold whole frames."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self.open, self.write, self.close = transport.open, transport.write, transport.close

    def read(self, timeout_s: float) -> Heard:
        """What has come."""
        data = self._transport.read(timeout_s)
        return [(None, data)] if data else []


class TcpIn:
    """Streams to every station that connects."""

    def __init__(self, address: Address) -> None:
        self._address = address
        self._listener: socket.socket | None = None
        self._stations: list[socket.socket] = []

    @property
    def port(self) -> int:
        """The port that stations connect to, once open."""
        return int(self._open.getsockname()[1])

    @property
    def _open(self) -> socket.socket:
        if self._listener is None:
            raise OSError("the socket is closed")
        return self._listener

    def open(self) -> None:
        """Listen."""
        self.close()
        self._listener = socket.create_server(self._address)

    def read(self, timeout_s: float) -> Heard:
        """What has come from each station; new ones are let in, those that left are forgotten."""
        heard: Heard = []
        for ready in select.select([self._open, *self._stations], [], [], timeout_s)[0]:
            if ready is self._listener:
                self._let_in()
                continue
            data = b""
            with suppress(OSError):
                data = ready.recv(_CHUNK)
            if data:
                heard.append((ready, data))
            else:
                self._drop(ready)
        return heard

    def _let_in(self) -> None:
        station, _ = self._open.accept()
        station.settimeout(_PATIENCE_S)
        self._stations.append(station)

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
        if self._listener is not None:
            self._listener.close()
            self._listener = None

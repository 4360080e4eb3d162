"""Sockets to ground stations: data goes to all that are connected, and comes with its sender.

``udp:HOST:PORT`` (or ``udpout:``) sends to a station that listens; ``udpin:HOST:PORT`` listens for
stations; ``tcp:HOST:PORT`` connects to a station that listens; ``tcpin:HOST:PORT`` accepts connections.
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
_SEND_S = 2.0
"""How long sending to a station may block: a station that blocks longer is disconnected."""

Address = tuple[str, int]
Received = list[tuple[Hashable, bytes]]
"""(sender, data)."""


class GroundStationSocket(Protocol):
    """A socket to ground stations, which can be reopened after an ``OSError``."""

    def open(self) -> None:
        """Open, or reopen."""

    def read(self, timeout_s: float) -> Received:
        """Data as soon as some arrives; empty after the timeout."""

    def write(self, frame: bytes) -> None:
        """Send a frame to all that are connected."""

    def close(self) -> None:
        """Close; no effect when closed."""


def socket_for(address: str) -> GroundStationSocket:
    """The socket that a ``--gcs`` address names.

    Raises:
        FlightReplayError: The address is invalid.
    """
    kind, _, rest = address.partition(":")
    host, _, port = rest.rpartition(":")
    host_port = (host.strip("[]"), int(port) if port.isdigit() else -1)
    if kind.lower() in _TRANSPORTS and host and 0 < host_port[1] < 65536:
        return TransportSocket(_TRANSPORTS[kind.lower()](host_port))
    if kind.lower() == "tcpin" and host and 0 <= host_port[1] < 65536:
        return TcpServer(host_port)
    raise FlightReplayError(
        f"invalid ground station {address!r}; write udp:HOST:PORT, udpin:HOST:PORT, "
        "tcp:HOST:PORT or tcpin:HOST:PORT"
    )


_TRANSPORTS: dict[str, type[UdpClient] | type[UdpListener] | type[TcpClient]] = {
    "udp": UdpClient,
    "udpout": UdpClient,
    "udpin": UdpListener,
    "tcp": TcpClient,
}


class TransportSocket:
    """A transport like that of a vehicle: one stream of bytes, or datagrams that each hold whole frames."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self.open, self.write, self.close = transport.open, transport.write, transport.close

    def read(self, timeout_s: float) -> Received:
        """Data that arrived."""
        data = self._transport.read(timeout_s)
        return [(self._transport.sender, data)] if data else []


class TcpServer:
    """A TCP server that any number of ground stations connect to."""

    def __init__(self, address: Address) -> None:
        self._address = address
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
        self._listener = socket.create_server(self._address)

    def read(self, timeout_s: float) -> Received:
        """Data of each station; accepts new stations, and drops those that closed the connection."""
        received: Received = []
        for ready in select.select([self._open_listener, *self._stations], [], [], timeout_s)[0]:
            if ready is self._listener:
                self._accept()
                continue
            data = b""
            with suppress(OSError):
                data = ready.recv(_CHUNK)
            if data:
                received.append((ready, data))
            else:
                self._drop(ready)
        return received

    def _accept(self) -> None:
        station, _ = self._open_listener.accept()
        station.settimeout(_SEND_S)
        self._stations.append(station)

    def write(self, frame: bytes) -> None:
        """Send to all that are connected; a station that does not receive is dropped."""
        for station in list(self._stations):
            try:
                station.sendall(frame)
            except OSError:
                self._drop(station)

    def _drop(self, station: socket.socket) -> None:
        self._stations.remove(station)
        station.close()

    def close(self) -> None:
        """Close, with every connection; no effect when closed."""
        for station in list(self._stations):
            self._drop(station)
        if self._listener is not None:
            self._listener.close()
            self._listener = None

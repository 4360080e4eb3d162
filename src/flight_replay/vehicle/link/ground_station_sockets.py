"""Sockets to ground stations: data goes to all that are connected, and comes with its sender.

``udp:HOST:PORT`` (or ``udpout:``) sends to a station that listens; ``udpin:HOST:PORT`` listens for
stations; ``tcp:HOST:PORT`` connects to a station that listens; ``tcpin:HOST:PORT`` accepts connections.
"""

from __future__ import annotations

import ipaddress
import logging
import select
import socket
import time
from collections.abc import Hashable, Sequence
from contextlib import suppress
from typing import Protocol

from flight_replay.errors import FlightReplayError
from flight_replay.vehicle.link.host_lookup import look_up
from flight_replay.vehicle.link.transport import TcpClient, Transport, UdpClient
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


class GroundStationSocket(Protocol):
    """A socket to ground stations, which can be reopened after an ``OSError``."""

    def open(self) -> None:
        """Open, or reopen."""

    listens: bool
    """Whether senders connect to us, and so have to be admitted before they act."""

    def read(self, timeout_s: float) -> Received:
        """Data as soon as some arrives; empty after the timeout. No data of a sender means that it left."""

    def admit(self, source: Hashable) -> None:
        """This sender is a ground station."""

    def drop(self, source: Hashable) -> None:
        """Disconnect this sender."""

    def write(self, frame: bytes) -> None:
        """Send a frame to all that are connected."""

    def close(self) -> None:
        """Close; no effect when closed."""


def socket_for(address: str, *, allow_open: bool = False) -> GroundStationSocket:
    """The socket that a ``--gcs`` address names.

    Args:
        address: as the module says.
        allow_open: whether it may listen on other addresses than loopback.

    Raises:
        FlightReplayError: The address is invalid, or would let other machines in.
    """
    kind, _, rest = address.partition(":")
    host, _, port = rest.rpartition(":")
    host_port = (host.strip("[]"), int(port) if port.isdecimal() and port.isascii() else -1)
    if kind.lower() in _TRANSPORTS and host and 0 < host_port[1] < 65536:
        return TransportSocket(_TRANSPORTS[kind.lower()](host_port))
    if kind.lower() in _SERVERS and host and 0 <= host_port[1] < 65536:
        if not allow_open and not _is_loopback(host_port[0]):
            raise FlightReplayError(
                f"{address} lets every machine that reaches it command the vehicle; "
                "listen on 127.0.0.1, or add --gcs-open if that is meant"
            )
        return _SERVERS[kind.lower()](host_port)
    raise FlightReplayError(
        f"invalid ground station {address!r}; write udp:HOST:PORT, udpin:HOST:PORT, "
        "tcp:HOST:PORT or tcpin:HOST:PORT"
    )


_TRANSPORTS: dict[str, type[UdpClient] | type[TcpClient]] = {
    "udp": UdpClient,
    "udpout": UdpClient,
    "tcp": TcpClient,
}


def check_distinct(connection: str | None, stations: Sequence[str]) -> None:
    """Refuse an address that is used twice, by ``--connect`` or ``--gcs``: frames would go in circles.

    Raises:
        FlightReplayError: One is.
    """
    used: set[tuple[str, str, str]] = set()
    for address in (*([] if connection is None else [connection]), *stations):
        place = _place(address)
        if place in used:
            raise FlightReplayError(f"{address} is used twice; give the ground station another port")
        if place is not None:
            used.add(place)


def _place(address: str) -> tuple[str, str, str] | None:
    """Protocol, host and port of an address, all names of this machine alike; None for a serial port."""
    kind, _, rest = address.partition(":")
    protocol = kind.lower()[:3]
    if protocol not in ("udp", "tcp"):
        protocol, rest = "udp", address
    host, colon, port = rest.rpartition(":")
    if not (colon and port.isdecimal()):
        return None
    host = host.strip("[]").lower()
    here = host in ("", "0.0.0.0", "::") or _is_loopback(host)
    return protocol, "this machine" if here else host, port


def _is_loopback(host: str) -> bool:
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class TransportSocket:
    """A connection of ours to a station, whose every frame is forwarded."""

    listens = False

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self.open, self.write, self.close = transport.open, transport.write, transport.close

    def read(self, timeout_s: float) -> Received:
        """Data that arrived."""
        data = self._transport.read(timeout_s)
        return [(self._transport.sender, data)] if data else []

    def admit(self, source: Hashable) -> None:
        """It is admitted already."""

    def drop(self, source: Hashable) -> None:
        """It is not dropped: the connection is ours."""


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
            received.append((ready, data))
            if not data:
                self._disconnect(ready)
        return received

    def _accept(self) -> None:
        if time.monotonic() < self._accept_after_s:
            return
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


_SERVERS: dict[str, type[TcpServer] | type[UdpServer]] = {"tcpin": TcpServer, "udpin": UdpServer}

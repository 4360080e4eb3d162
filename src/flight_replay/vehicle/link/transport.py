"""Bytes to a vehicle and back, over the connection strings that DroneKit's users type.

``tcp:HOST:PORT`` connects; ``udp:HOST:PORT``, ``udpin:HOST:PORT`` and plain ``HOST:PORT`` listen, and
answer whoever was heard; ``udpout:HOST:PORT`` speaks first; anything else is a serial port.
"""

from __future__ import annotations

import select
import socket
from typing import Any, Protocol

from flight_replay.errors import VehicleError
from flight_replay.vehicle.link.host_lookup import AddressInfo, look_up

_CONNECT_S = 3.0
_LOOK_UP_S = 4.0  # Less than closing a link waits for its thread.
_CHUNK = 65536


class Transport(Protocol):
    """A way to carry bytes that can be opened again after it broke; ``OSError`` tells that it broke."""

    dies_silently: bool
    """Whether it can be dead without telling, so that a long silence is reason to open it again."""

    def open(self) -> None:
        """Open, or open again."""

    def read(self, timeout_s: float) -> bytes:
        """What has come, as soon as something has; nothing after the timeout."""

    def write(self, data: bytes) -> None:
        """Send, as one datagram where there are datagrams."""

    def close(self) -> None:
        """Close; harmless when closed."""


class _Socket:
    """What the socket transports share: waiting, and closing."""

    dies_silently = False

    def __init__(self, address: tuple[str, int]) -> None:
        self._address = address
        self._socket: socket.socket | None = None

    @property
    def _open_socket(self) -> socket.socket:
        if self._socket is None:
            raise OSError("the connection is closed")
        return self._socket

    def _new(self, kind: socket.SocketKind) -> tuple[socket.socket, Any]:
        """A socket of the address's family, and the address in that family's form."""
        family, _, _, _, address = look_up(*self._address, _LOOK_UP_S, kind)[0]
        return socket.socket(family, kind), address

    def _readable(self, timeout_s: float) -> bool:
        return bool(select.select([self._open_socket], [], [], timeout_s)[0])

    def close(self) -> None:
        """Close; harmless when closed."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _connected(places: list[AddressInfo]) -> socket.socket:
    """A connection to the first of a host's addresses that takes one; the last one's refusal if none does."""
    refusal: OSError | None = None
    for family, kind, protocol, _, address in places:
        connection = socket.socket(family, kind, protocol)
        try:
            connection.settimeout(_CONNECT_S)
            connection.connect(address)
        except OSError as error:
            connection.close()
            refusal = error
        else:
            return connection
    raise refusal or OSError("the host has no address")


class TcpClient(_Socket):
    """A stream to a vehicle that listens; a connection that a router forgot stays open and silent."""

    dies_silently = True

    def open(self) -> None:
        """Connect, in seconds at most."""
        self.close()
        self._socket = _connected(look_up(*self._address, _LOOK_UP_S))
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def read(self, timeout_s: float) -> bytes:
        """What has come; an end of the stream is an error."""
        if not self._readable(timeout_s):
            return b""
        data = self._open_socket.recv(_CHUNK)
        if not data:
            raise ConnectionResetError("the vehicle closed the connection")
        return data

    def write(self, data: bytes) -> None:
        """Send all of it, in seconds at most."""
        self._open_socket.sendall(data)


class UdpListener(_Socket):
    """Datagrams from whoever sends them here, and answers to all of those."""

    def open(self) -> None:
        """Listen at the address."""
        self.close()
        self._heard: set[Any] = set()
        self._socket, address = self._new(socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self._socket.bind(address)

    def read(self, timeout_s: float) -> bytes:
        """One datagram."""
        if not self._readable(timeout_s):
            return b""
        try:
            data, sender = self._open_socket.recvfrom(_CHUNK)
        except ConnectionError:
            return b""  # An earlier answer was not wanted: the vehicle may be restarting.
        self._heard.add(sender)
        return data

    def write(self, data: bytes) -> None:
        """Send to all who were heard."""
        for sender in self._heard:
            self._open_socket.sendto(data, sender)


class UdpClient(_Socket):
    """Datagrams to a vehicle that waits to be spoken to."""

    def open(self) -> None:
        """Make ready to speak."""
        self.close()
        self._socket, address = self._new(socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self._socket.connect(address)

    def read(self, timeout_s: float) -> bytes:
        """One datagram."""
        try:
            return self._open_socket.recv(_CHUNK) if self._readable(timeout_s) else b""
        except ConnectionError:
            return b""  # Nobody listens there yet, or no more.

    def write(self, data: bytes) -> None:
        """Send; whether somebody listens shows only in what comes back."""
        try:
            self._open_socket.send(data)
        except ConnectionError:
            return


class Serial:
    """A serial port: a telemetry radio, or the autopilot's own USB."""

    dies_silently = False

    def __init__(self, device: str, baud: int) -> None:
        self._device, self._baud = device, baud
        self._port: Any = None

    def open(self) -> None:
        """Open the port.

        Raises:
            VehicleError: pyserial is missing.
        """
        try:
            import serial
        except ImportError as error:
            raise VehicleError(
                f"the serial port {self._device} needs pyserial; install it with: pip install pyserial"
            ) from error
        self.close()
        self._port = serial.Serial(self._device, self._baud, timeout=0.05, write_timeout=1.0)

    def read(self, timeout_s: float) -> bytes:
        """What has come."""
        self._port.timeout = timeout_s
        first: bytes = self._port.read(1)
        return first + self._port.read(self._port.in_waiting) if first else b""

    def write(self, data: bytes) -> None:
        """Send, within the port's time limit."""
        self._port.write(data)

    def close(self) -> None:
        """Close; harmless when closed."""
        if self._port is not None:
            self._port.close()
            self._port = None

"""Bytes to and from a vehicle, over the transports that connection strings name.

``tcp:HOST:PORT`` connects; ``udp:HOST:PORT``, ``udpin:HOST:PORT`` and plain ``HOST:PORT`` listen, and
send to every address that data came from; ``udpout:HOST:PORT`` sends first; anything else is a serial
port.
"""

from __future__ import annotations

import select
import socket
import time
from contextlib import suppress
from typing import Any, Protocol

from flight_replay.exceptions import VehicleError
from flight_replay.vehicle.link.host_lookup import AddressInfo, look_up
from flight_replay.vehicle.link.udp_peers import UdpPeers

_CONNECT_S = 3.0
_LOOK_UP_S = 4.0  # Less than closing a link waits for its thread.
_CHUNK = 65536


class Transport(Protocol):
    """A byte stream or datagrams, which can be reopened after an ``OSError``."""

    sender: Any
    """Who sent what ``read`` returned last, where there can be several; else None."""
    reopen_if_silent: bool
    """Whether it can be dead without an error, so that it has to be reopened after a long silence."""

    def open(self) -> None:
        """Open, or reopen."""

    def read(self, timeout_s: float) -> bytes:
        """Data as soon as some arrives; empty after the timeout."""

    def write(self, data: bytes) -> None:
        """Send, as one datagram where there are datagrams."""

    def send_only_to(self, sender: Any) -> None:
        """Send to this sender only, from now on; harmless where there is only one."""

    def close(self) -> None:
        """Close; no effect when closed."""


class _OneSender:
    """A transport with one other end."""

    sender: Any = None

    def send_only_to(self, sender: Any) -> None:
        """There is only one."""


class _SocketTransport(_OneSender):
    """What the socket transports share."""

    reopen_if_silent = False

    def __init__(self, address: tuple[str, int]) -> None:
        self._address = address
        self._socket: socket.socket | None = None

    @property
    def _open_socket(self) -> socket.socket:
        if self._socket is None:
            raise OSError("the connection is closed")
        return self._socket

    def _new_socket(self, kind: socket.SocketKind) -> tuple[socket.socket, Any]:
        """A socket of the address's family, and the address in that family's form."""
        family, _, _, _, address = look_up(*self._address, _LOOK_UP_S, kind)[0]
        return socket.socket(family, kind), address

    def _readable(self, timeout_s: float) -> bool:
        return bool(select.select([self._open_socket], [], [], timeout_s)[0])

    def close(self) -> None:
        """Close; no effect when closed."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _connect_to_first(addresses: list[AddressInfo]) -> socket.socket:
    """A connection to the first address that accepts one; the error of the last one if none does."""
    refusal: OSError | None = None
    for family, kind, protocol, _, address in addresses:
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


class TcpClient(_SocketTransport):
    """A TCP connection to a vehicle that listens."""

    reopen_if_silent = True  # A router that forgot the connection does not say so.

    def open(self) -> None:
        """Connect, within seconds."""
        self.close()
        self._socket = _connect_to_first(look_up(*self._address, _LOOK_UP_S))
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def read(self, timeout_s: float) -> bytes:
        """Data that arrived; the end of the stream is an error."""
        if not self._readable(timeout_s):
            return b""
        data = self._open_socket.recv(_CHUNK)
        if not data:
            raise ConnectionResetError("the vehicle closed the connection")
        return data

    def write(self, data: bytes) -> None:
        """Send all of it, within seconds."""
        self._open_socket.sendall(data)


class UdpListener(_SocketTransport):
    """UDP that listens at an address, and sends to the vehicle; while that is not known, to its peers."""

    def __init__(self, address: tuple[str, int]) -> None:
        super().__init__(address)
        self._peers = UdpPeers()

    def open(self) -> None:
        """Listen at the address."""
        self.close()
        self._socket, address = self._new_socket(socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self._socket.bind(address)

    def read(self, timeout_s: float) -> bytes:
        """One datagram."""
        if not self._readable(timeout_s):
            return b""
        try:
            data, sender = self._open_socket.recvfrom(_CHUNK)
        except ConnectionError:
            return b""  # An earlier datagram was refused: the vehicle may be restarting.
        self.sender = sender
        self._peers.received(sender, time.monotonic())
        return data

    def write(self, data: bytes) -> None:
        """Send to the vehicle or to all peers; one that cannot be reached does not stop the others."""
        for address in self._peers.addresses:
            with suppress(OSError):
                self._open_socket.sendto(data, address)

    def send_only_to(self, sender: Any) -> None:
        """Send to this sender only, from now on."""
        self._peers.send_only_to(sender)


class UdpClient(_SocketTransport):
    """UDP to a vehicle that listens at an address."""

    def open(self) -> None:
        """Open the socket; nothing is sent yet."""
        self.close()
        self._socket, address = self._new_socket(socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self._socket.connect(address)

    def read(self, timeout_s: float) -> bytes:
        """One datagram."""
        try:
            return self._open_socket.recv(_CHUNK) if self._readable(timeout_s) else b""
        except ConnectionError:
            return b""  # Nothing listens there yet, or no longer.

    def write(self, data: bytes) -> None:
        """Send; no error tells whether anything listens there."""
        try:
            self._open_socket.send(data)
        except ConnectionError:
            return


class Serial(_OneSender):
    """A serial port: a telemetry radio, or the autopilot's USB port."""

    reopen_if_silent = False

    def __init__(self, device: str, baud: int) -> None:
        self._device, self.baud = device, baud
        self._port: Any = None

    def open(self) -> None:
        """Open the port.

        Raises:
            VehicleError: pyserial is not installed.
        """
        try:
            import serial
        except ImportError as error:
            raise VehicleError(
                f"serial port {self._device} needs pyserial; install it with: pip install pyserial"
            ) from error
        self.close()
        self._port = serial.Serial(self._device, self.baud, timeout=0.05, write_timeout=1.0)

    def read(self, timeout_s: float) -> bytes:
        """Data that arrived."""
        self._port.timeout = timeout_s
        first: bytes = self._port.read(1)
        return first + self._port.read(self._port.in_waiting) if first else b""

    def write(self, data: bytes) -> None:
        """Send, within the port's time limit."""
        self._port.write(data)

    def close(self) -> None:
        """Close; no effect when closed."""
        if self._port is not None:
            self._port.close()
            self._port = None

"""Links over the network: TCP and UDP that listen, UDP that sends to an address. Nothing blocks."""

from __future__ import annotations

import contextlib
import os
import socket
from typing import Protocol

from flight_replay.exceptions import SimulatorError
from flight_replay.simulator.server.addresses import NetworkAddress

_BUFFER = 65536
# With more unsent bytes than this, telemetry pauses; with more than the other, the station is disconnected.
_PAUSE_UNSENT = 1 << 18
_CLOSE_UNSENT = 1 << 22


class ClientSocket(Protocol):
    """The connection to one station: bytes both ways."""

    socket: socket.socket

    @property
    def is_open(self) -> bool:
        """Whether the connection is open, as far as is known."""

    @property
    def has_room(self) -> bool:
        """Whether more bytes can be sent without a growing queue."""

    def read(self) -> list[bytes]:
        """What has been received."""

    def write(self, data: bytes) -> None:
        """Send, now or when there is room."""

    def flush(self) -> None:
        """Send what is queued."""

    def close(self) -> None:
        """Close the connection."""


class TcpClientSocket:
    """The connection to a TCP client."""

    def __init__(self, sock: socket.socket) -> None:
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket = sock
        self.is_open = True
        self._unsent = bytearray()

    @property
    def has_room(self) -> bool:
        """Whether the queue is short."""
        return len(self._unsent) < _PAUSE_UNSENT

    def read(self) -> list[bytes]:
        """What has been received; an end or a reset closes the connection."""
        try:
            data = self.socket.recv(_BUFFER)
        except (BlockingIOError, InterruptedError):
            return []
        except OSError:
            data = b""
        if not data:
            self.is_open = False
            return []
        return [data]

    def write(self, data: bytes) -> None:
        """Queue bytes; ``flush`` sends them."""
        self._unsent += data
        if len(self._unsent) > _CLOSE_UNSENT:
            self.is_open = False

    def flush(self) -> None:
        """Send as much of the queue as the system takes."""
        if not self._unsent or not self.is_open:
            return
        try:
            sent = self.socket.send(self._unsent)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            self.is_open = False
            return
        del self._unsent[:sent]

    def close(self) -> None:
        """Close the connection."""
        self.is_open = False
        self.socket.close()


class UdpClientSocket:
    """A UDP peer: the one that the socket is connected to, or the last sender."""

    is_open = True
    has_room = True

    def __init__(self, sock: socket.socket, *, connected: bool) -> None:
        sock.setblocking(False)
        self.socket = sock
        self._connected = connected
        self._peer: tuple[str, int] | None = None

    def read(self) -> list[bytes]:
        """Every datagram that was received."""
        found: list[bytes] = []
        # An error is an ICMP answer to something sent: nothing listens there yet.
        with contextlib.suppress(OSError):
            while True:
                data, self._peer = self.socket.recvfrom(_BUFFER)
                found.append(data)
        return found

    def write(self, data: bytes) -> None:
        """Send one datagram per message; what the system does not take is lost, as on a radio."""
        with contextlib.suppress(OSError):
            if self._connected:
                self.socket.send(data)
            elif self._peer is not None:
                self.socket.sendto(data, self._peer)

    def flush(self) -> None:
        """Nothing is queued."""

    def close(self) -> None:
        """Close the port."""
        self.socket.close()


def _family(host: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ":" in host else socket.AF_INET


class ListenSocket:
    """A socket that accepts stations; ``address`` has the port that was chosen for port 0."""

    def __init__(self, address: NetworkAddress) -> None:
        """Open the link.

        Raises:
            SimulatorError: if the port is in use, or the host is not one of this machine.
        """
        is_tcp = address.kind == "tcp"
        self.socket = socket.socket(
            _family(address.host), socket.SOCK_STREAM if is_tcp else socket.SOCK_DGRAM
        )
        self._udp: UdpClientSocket | None = None
        try:
            self._open(address)
        except OSError as error:
            self.socket.close()
            raise SimulatorError(
                f"cannot listen on {address}: {error.strerror or error}; choose another address with --listen"
            ) from error

    def _open(self, address: NetworkAddress) -> None:
        if address.kind == "udpout":
            self.socket.connect((address.host, address.port))
            self.address = address
            self._udp = UdpClientSocket(self.socket, connected=True)
            return
        if address.kind == "tcp" and os.name != "nt":
            # On Windows the option would let two programs share the port.
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind((address.host, address.port))
        self.address = NetworkAddress(address.kind, address.host, self.socket.getsockname()[1])
        if address.kind == "tcp":
            self.socket.listen()
            self.socket.setblocking(False)
        else:
            self._udp = UdpClientSocket(self.socket, connected=False)

    def accept(self) -> ClientSocket | None:
        """A station that has connected: each TCP client once, the one UDP peer at the first call."""
        if self.address.kind != "tcp":
            udp, self._udp = self._udp, None
            return udp
        try:
            client, _ = self.socket.accept()
        except OSError:  # Gone again, or out of descriptors: those that are connected must not suffer.
            return None
        return TcpClientSocket(client)

    def close(self) -> None:
        """Close the port."""
        self.socket.close()

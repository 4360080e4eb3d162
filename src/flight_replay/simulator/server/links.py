"""Links over the network: TCP that is listened on, UDP that is sent to or listened on. Nothing blocks."""

from __future__ import annotations

import contextlib
import os
import socket
from typing import Protocol

from flight_replay.errors import SimulatorError
from flight_replay.simulator.server.addresses import Address

_BUFFER = 65536
# More unsent bytes than this and telemetry pauses; a station that never reads is let go beyond the other.
_ENOUGH_UNSENT = 1 << 18
_TOO_MUCH_UNSENT = 1 << 22


class Connection(Protocol):
    """One station's end: bytes both ways."""

    socket: socket.socket

    @property
    def is_open(self) -> bool:
        """Whether the other side may still be there."""

    @property
    def has_room(self) -> bool:
        """Whether it takes more bytes without piling them up."""

    def read(self) -> list[bytes]:
        """What has come in."""

    def write(self, data: bytes) -> None:
        """Send, now or as soon as there is room."""

    def flush(self) -> None:
        """Send what waits."""

    def close(self) -> None:
        """Hang up."""


class TcpConnection:
    """A TCP client."""

    def __init__(self, sock: socket.socket) -> None:
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket = sock
        self.is_open = True
        self._unsent = bytearray()

    @property
    def has_room(self) -> bool:
        """Whether little is waiting to be sent."""
        return len(self._unsent) < _ENOUGH_UNSENT

    def read(self) -> list[bytes]:
        """What has come in; an end or a reset closes the connection."""
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
        if len(self._unsent) > _TOO_MUCH_UNSENT:
            self.is_open = False

    def flush(self) -> None:
        """Send what the system takes."""
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
        """Hang up."""
        self.is_open = False
        self.socket.close()


class UdpConnection:
    """A UDP peer: the one that the socket is connected to, or whoever sent last."""

    is_open = True
    has_room = True

    def __init__(self, sock: socket.socket, *, connected: bool) -> None:
        sock.setblocking(False)
        self.socket = sock
        self._connected = connected
        self._peer: tuple[str, int] | None = None

    def read(self) -> list[bytes]:
        """Every datagram that waits."""
        found: list[bytes] = []
        # An error is an ICMP refusal of something sent: nobody listens there yet.
        with contextlib.suppress(OSError):
            while True:
                data, self._peer = self.socket.recvfrom(_BUFFER)
                found.append(data)
        return found

    def write(self, data: bytes) -> None:
        """One datagram for each message; what the system does not take is lost, as on the air."""
        with contextlib.suppress(OSError):
            if self._connected:
                self.socket.send(data)
            elif self._peer is not None:
                self.socket.sendto(data, self._peer)

    def flush(self) -> None:
        """Nothing waits."""

    def close(self) -> None:
        """Let go of the port."""
        self.socket.close()


def _family(host: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ":" in host else socket.AF_INET


class Listener:
    """An open link: ``address`` has the port that was given to port 0."""

    def __init__(self, address: Address) -> None:
        """Open the link.

        Raises:
            SimulatorError: if the port is in use, or the host is not this machine's.
        """
        is_tcp = address.kind == "tcp"
        self.socket = socket.socket(
            _family(address.host), socket.SOCK_STREAM if is_tcp else socket.SOCK_DGRAM
        )
        self._single: UdpConnection | None = None
        try:
            self._open(address)
        except OSError as error:
            self.socket.close()
            raise SimulatorError(
                f"cannot listen on {address}: {error.strerror or error}; choose another port with --listen"
            ) from error

    def _open(self, address: Address) -> None:
        if address.kind == "udpout":
            self.socket.connect((address.host, address.port))
            self.address = address
            self._single = UdpConnection(self.socket, connected=True)
            return
        if address.kind == "tcp" and os.name != "nt":
            # On Windows the option would let two programs share the port.
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind((address.host, address.port))
        self.address = Address(address.kind, address.host, self.socket.getsockname()[1])
        if address.kind == "tcp":
            self.socket.listen()
            self.socket.setblocking(False)
        else:
            self._single = UdpConnection(self.socket, connected=False)

    def accept(self) -> Connection | None:
        """A station that has come: each TCP client once, the one UDP connection at the first call."""
        if self.address.kind != "tcp":
            single, self._single = self._single, None
            return single
        try:
            client, _ = self.socket.accept()
        except (BlockingIOError, InterruptedError, ConnectionError):
            return None
        return TcpConnection(client)

    def close(self) -> None:
        """Let go of the port."""
        self.socket.close()

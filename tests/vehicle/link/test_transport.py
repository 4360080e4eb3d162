"""Connection strings as for DroneKit, over real sockets on loopback and a real terminal."""

from __future__ import annotations

import errno
import os
import socket
import sys
import threading
from collections.abc import Iterator

import pytest

from flight_replay.exceptions import VehicleError
from flight_replay.vehicle.link import connection_string, transport
from flight_replay.vehicle.link.connection_string import open_transport, transport_for
from flight_replay.vehicle.link.transport import Serial, TcpClient, Transport, UdpClient, UdpListener

STRINGS = {
    "tcp:127.0.0.1:5760": TcpClient,
    "TCP:localhost:5760": TcpClient,
    "udp:127.0.0.1:14550": UdpListener,
    "udpin:0.0.0.0:14550": UdpListener,
    "udpin::14550": UdpListener,
    "127.0.0.1:14550": UdpListener,
    "udpout:127.0.0.1:14550": UdpClient,
    "tcp:[::1]:5760": TcpClient,
    "/dev/ttyUSB0": Serial,
    "/dev/serial/by-id/usb-3D_Robotics:1": Serial,
    "COM14": Serial,
    "com14,57600": Serial,
    "com14,²": Serial,
}


@pytest.mark.parametrize(("text", "kind"), STRINGS.items())
def test_each_connection_string_has_its_transport(text: str, kind: type) -> None:
    """TCP connects, UDP listens or sends first, and anything else is a serial port."""
    assert type(transport_for(text, 57600)) is kind


@pytest.mark.parametrize(
    "text",
    ["", ",57600", "tcp:127.0.0.1", "udp:host:port", "udpout:host:0", "tcp:host:99999", "tcpin:host:5760"],
)
def test_an_invalid_connection_string_is_refused(text: str) -> None:
    """The error shows the valid forms."""
    with pytest.raises(VehicleError, match="write tcp:HOST:PORT"):
        transport_for(text, 57600)


@pytest.fixture
def server() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        yield listening


def address(bound: socket.socket) -> str:
    return f"127.0.0.1:{bound.getsockname()[1]}"


def read_all(transport: Transport, length: int) -> bytes:
    data = b""
    while len(data) < length:
        data += transport.read(60.0)
    return data


def test_tcp_reports_a_closed_connection(server: socket.socket) -> None:
    """Bytes pass both ways; the end of the stream is an error, after which it can be reopened."""
    transport = open_transport(f"tcp:{address(server)}", 0)
    vehicle, _ = server.accept()
    vehicle.sendall(b"hello")
    assert read_all(transport, 5) == b"hello"
    transport.write(b"there")
    assert vehicle.recv(5) == b"there"
    assert transport.read(0.01) == b""
    vehicle.close()
    with pytest.raises(ConnectionResetError):
        transport.read(60.0)
    transport.open()
    server.accept()[0].close()
    transport.close()
    with pytest.raises(OSError, match="closed"):
        transport.write(b"x")


def test_a_udp_listener_sends_to_the_addresses_it_received_from() -> None:
    """Before it received anything, what is sent is dropped."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle, FreePort() as port:
        transport = open_transport(f"127.0.0.1:{port.release()}", 0)
        transport.write(b"nobody")
        vehicle.settimeout(60)
        vehicle.sendto(b"hello", ("127.0.0.1", port.number))
        assert transport.read(60.0) == b"hello"
        transport.write(b"there")
        assert vehicle.recv(100) == b"there"
        assert transport.read(0.01) == b""
        transport.close()
        transport.close()


class FreePort:
    """A UDP port that is free: held until released."""

    def __enter__(self) -> FreePort:
        self._held = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._held.bind(("127.0.0.1", 0))
        self.number = self._held.getsockname()[1]
        return self

    def release(self) -> int:
        self._held.close()
        return int(self.number)

    def __exit__(self, *_: object) -> None:
        self._held.close()


def test_a_udp_client_waits_for_the_vehicle() -> None:
    """A refused datagram is not an error; once the vehicle listens, both ways work."""
    with FreePort() as port:
        transport = open_transport(f"udpout:127.0.0.1:{port.release()}", 0)
        for _ in range(3):
            transport.write(b"anybody?")
            assert transport.read(0.02) == b""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
            vehicle.bind(("127.0.0.1", port.number))
            vehicle.settimeout(60)
            transport.write(b"hello")
            data, sender = vehicle.recvfrom(100)
            vehicle.sendto(b"there", sender)
            assert data == b"hello"
            assert transport.read(60.0) == b"there"
        transport.close()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_a_serial_port_carries_bytes() -> None:
    """A pseudo-terminal in place of the radio."""
    ours, name = os.openpty()
    transport = open_transport(os.ttyname(name), 57600)
    os.write(ours, b"hello")
    assert read_all(transport, 5) == b"hello"
    transport.write(b"there")
    assert os.read(ours, 5) == b"there"
    assert transport.read(0.01) == b""
    transport.close()
    transport.close()
    os.close(ours)
    os.close(name)


def test_a_serial_port_without_pyserial_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """If pyserial is missing, the error has the command to install it."""
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(VehicleError, match="pip install pyserial"):
        open_transport("/dev/ttyUSB0", 57600)


def test_what_cannot_be_opened_is_an_error_at_once(
    monkeypatch: pytest.MonkeyPatch, server: socket.socket
) -> None:
    """A missing device, an unknown host, a port in use, and nothing listening: one line each."""
    monkeypatch.setattr(connection_string, "_RETRY_S", 0.1)
    with pytest.raises(VehicleError, match="cannot open /dev/no-such-port: No such file or directory; check"):
        open_transport("/dev/no-such-port", 57600)
    with pytest.raises(VehicleError, match="cannot resolve the host"):
        open_transport("tcp:no-such-host.invalid:5760", 0)
    with pytest.raises(VehicleError, match="invalid host name; check the host name"):
        open_transport("tcp:two..dots:5760", 0)
    with FreePort() as held, pytest.raises(VehicleError, match="let the vehicle send to another port"):
        open_transport(f"udp:127.0.0.1:{held.number}", 0)
    number = server.getsockname()[1]
    server.close()
    with pytest.raises(
        VehicleError,
        match=r"refused: nothing listens there; start .* \(flight-replay waits for it with --wait\)",
    ):
        open_transport(f"tcp:127.0.0.1:{number}", 0)


@pytest.mark.parametrize(
    ("number", "next_step"),
    [
        (errno.EACCES, "Permission denied; let your user use it"),
        (errno.EADDRNOTAVAIL, "requested address; udp: listens, at addresses of this computer; udpout:"),
    ],
)
def test_what_may_not_be_opened_names_the_next_step(
    monkeypatch: pytest.MonkeyPatch, number: int, next_step: str
) -> None:
    """A serial port of another group, and an address of another computer."""

    def fail(_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(UdpListener, "open", fail)
    with pytest.raises(VehicleError, match=f"cannot open udp:10.0.0.9:14550: .*{next_step}"):
        open_transport("udp:10.0.0.9:14550", 0)


def test_a_silent_name_server_has_a_time_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """During which Ctrl-C works."""
    over = threading.Event()
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: [over.wait(10)])
    monkeypatch.setattr(transport, "_LOOK_UP_S", 0.2)
    with pytest.raises(VehicleError, match=r"no answer for host name slow\.invalid in 0.2 s"):
        open_transport("tcp:slow.invalid:5760", 0)
    over.set()


def test_a_host_is_looked_up_once_and_each_of_its_addresses_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """A second look-up would have no time limit; the first address may not answer."""
    asked: list[str] = []
    with socket.create_server(("127.0.0.1", 0)) as server, socket.create_server(("127.0.0.1", 0)) as gone:
        port, dead = server.getsockname()[1], gone.getsockname()
        gone.close()

        def addresses(host: str, *_: object, **__: object) -> list[object]:
            asked.append(host)
            return [(socket.AF_INET, socket.SOCK_STREAM, 0, "", at) for at in (dead, ("127.0.0.1", port))]

        monkeypatch.setattr(socket, "getaddrinfo", addresses)
        open_transport(f"tcp:drone.invalid:{port}", 0).close()
    assert asked == ["drone.invalid"]

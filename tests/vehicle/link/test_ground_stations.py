"""Ground stations that share the link: who receives, who may send, and who is disconnected."""

from __future__ import annotations

import errno
import queue
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as dialect

from flight_replay.exceptions import FlightReplayError
from flight_replay.vehicle.link.frame_parser import MAX_SENDERS
from flight_replay.vehicle.link.ground_station_servers import MAX_CONNECTIONS, TcpServer, UdpServer
from flight_replay.vehicle.link.ground_station_sockets import (
    TransportSocket,
    check_can_listen,
    check_distinct,
    socket_for,
)
from flight_replay.vehicle.link.ground_stations import QUEUED_FRAMES, GroundStation, ground_stations
from tests.helpers.machine import outside_address

PATIENCE_S = 10.0


class FakeLink:
    """A link that keeps what is forwarded to the vehicle, and delivers what the test sends as the vehicle."""

    def __init__(self) -> None:
        self.receivers: list[Callable[[Any], None]] = []
        self.heard: queue.Queue[bytes] = queue.Queue()
        self.added = threading.Event()

    def add_receiver(self, receiver: Callable[[Any], None]) -> None:
        self.receivers.append(receiver)

    def remove_receiver(self, receiver: Callable[[Any], None]) -> None:
        self.receivers.remove(receiver)

    def forward(self, frame: bytes) -> None:
        self.heard.put(frame)

    def speak(self, frame: bytes) -> None:
        """The vehicle sends a frame."""
        (message,) = dialect.MAVLink(None).parse_buffer(frame)
        for receiver in self.receivers:
            receiver(message)


def frame(number: int = 0, system: int = 1) -> bytes:
    """A numbered MAVLink 2 frame."""
    packed = dialect.MAVLink_system_time_message(number, number).pack(dialect.MAVLink(None, system, 1))
    return bytes(packed)


def command() -> bytes:
    """A command of a ground station, in MAVLink 1."""
    message = dialect.MAVLink_command_long_message(1, 1, dialect.MAV_CMD_DO_SET_MODE, 0, 1, 4, 0, 0, 0, 0, 0)
    return bytes(message.pack(dialect.MAVLink(None, 255, 190), force_mavlink1=True))


def beat() -> bytes:
    """The heartbeat of a ground station."""
    message = dialect.MAVLink_heartbeat_message(
        dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID, 0, 0, dialect.MAV_STATE_ACTIVE, 3
    )
    return bytes(message.pack(dialect.MAVLink(None, 255, 190)))


@contextmanager
def listening(kind: socket.SocketKind) -> Iterator[socket.socket]:
    """A socket of a ground station at a free port on loopback."""
    with socket.socket(socket.AF_INET, kind) as station:
        station.settimeout(PATIENCE_S)
        station.bind(("127.0.0.1", 0))
        if kind == socket.SOCK_STREAM:
            station.listen()
        yield station


def receive(stream: socket.socket, count: int) -> bytes:
    """Exactly so many bytes of a stream."""
    data = b""
    while len(data) < count:
        part = stream.recv(count - len(data))
        assert part, "the stream ended early"
        data += part
    return data


def test_a_station_that_listens_on_udp_receives_and_commands() -> None:
    """Frames pass unchanged in both directions."""
    link = FakeLink()
    with listening(socket.SOCK_DGRAM) as station:
        with ground_stations(link, [f"udpout:127.0.0.1:{station.getsockname()[1]}"]):
            link.speak(frame(1))
            data, sender = station.recvfrom(4096)
            assert data == frame(1)
            station.sendto(command(), sender)
            assert link.heard.get(timeout=PATIENCE_S) == command()
        assert link.receivers == []


def test_udpin_sends_to_the_stations_that_sent() -> None:
    """The addresses are learnt from received datagrams."""
    with listening(socket.SOCK_DGRAM) as free:
        address = free.getsockname()
    link = FakeLink()
    with (
        ground_stations(link, [f"udpin:127.0.0.1:{address[1]}"]) as (station,),
        listening(socket.SOCK_DGRAM) as gcs,
    ):
        assert station.opened.wait(PATIENCE_S)
        gcs.sendto(beat(), address)
        gcs.sendto(command(), address)
        assert link.heard.get(timeout=PATIENCE_S) == beat()
        assert link.heard.get(timeout=PATIENCE_S) == command()
        link.speak(frame(2))
        assert gcs.recv(4096) == frame(2)


def decoded(data: bytes) -> Any:
    """The message in a frame."""
    (message,) = dialect.MAVLink(None).parse_buffer(data)
    return message


@contextmanager
def running(station: GroundStation) -> Iterator[GroundStation]:
    """A station that is open, and closed in the end."""
    station.start()
    try:
        assert station.opened.wait(PATIENCE_S)
        yield station
    finally:
        station.close()


def test_bytes_of_two_tcp_stations_do_not_mix() -> None:
    """Half a command of one station and a whole one of another arrive as two whole commands."""
    sockets = TcpServer(("127.0.0.1", 0))
    link = FakeLink()
    with running(GroundStation("tcpin", sockets, link.forward)) as station:
        address = ("127.0.0.1", sockets.port)
        with (
            socket.create_connection(address, PATIENCE_S) as one,
            socket.create_connection(address, PATIENCE_S) as two,
        ):
            for each in (one, two):
                each.sendall(beat())
                assert link.heard.get(timeout=PATIENCE_S) == beat()
            one.sendall(command()[:10])
            two.sendall(frame(7, system=255))
            assert link.heard.get(timeout=PATIENCE_S) == frame(7, system=255)
            one.sendall(command()[10:])
            assert link.heard.get(timeout=PATIENCE_S) == command()
            station.receive(decoded(frame(3)))
            assert receive(one, len(frame(3))) == receive(two, len(frame(3))) == frame(3)
        with socket.create_connection(address, PATIENCE_S) as late:
            late.sendall(beat() + command())
            assert link.heard.get(timeout=PATIENCE_S) == beat()
            assert link.heard.get(timeout=PATIENCE_S) == command()


def test_a_broken_tcp_connection_is_reopened() -> None:
    """A station that listens on TCP may be restarted: the frames go on."""
    link = FakeLink()
    with (
        listening(socket.SOCK_STREAM) as station,
        ground_stations(link, [f"tcp:127.0.0.1:{station.getsockname()[1]}"]),
    ):
        first, _ = station.accept()
        link.speak(frame(1))
        assert receive(first, len(frame(1))) == frame(1)
        first.close()
        second, _ = station.accept()
        with second:
            second.settimeout(PATIENCE_S)
            link.speak(frame(2))
            assert receive(second, len(frame(2))) == frame(2)
            second.sendall(b"noise" + command())
            assert link.heard.get(timeout=PATIENCE_S) == command()


def test_queued_frames_are_sent_before_closing() -> None:
    """The last frames reach the station."""
    link = FakeLink()
    with listening(socket.SOCK_STREAM) as station:
        with ground_stations(link, [f"tcp:127.0.0.1:{station.getsockname()[1]}"]) as (made,):
            peer, _ = station.accept()
            assert made.opened.wait(PATIENCE_S)
            for number in range(200):
                link.speak(frame(number))
        with peer:
            sent = b"".join(frame(number) for number in range(200))
            assert receive(peer, len(sent)) == sent


def test_an_absent_station_delays_nothing() -> None:
    """The queue drops the oldest frames, and closing is quick."""
    with listening(socket.SOCK_DGRAM) as nobody:
        port = nobody.getsockname()[1]
    link = FakeLink()
    with ground_stations(link, [f"tcp:127.0.0.1:{port}", f"udpout:127.0.0.1:{port}"]) as (stream, _):
        for number in range(QUEUED_FRAMES + 100):
            link.speak(frame(number))
        assert len(stream._queue) == QUEUED_FRAMES


@pytest.mark.parametrize(
    ("kind", "other", "type"),
    [("udp", "udpout", socket.SOCK_DGRAM), ("tcpin", "tcp", socket.SOCK_STREAM)],
)
def test_a_port_that_a_station_listens_at_is_refused(kind: str, other: str, type: socket.SocketKind) -> None:
    """With the address that was probably meant; sending there is accepted."""
    with listening(type) as station:
        port = station.getsockname()[1]
        message = rf"at {kind}:127.0.0.1:{port}: .* in use; .* by {other}:127.0.0.1:{port}"
        with pytest.raises(FlightReplayError, match=message):
            check_can_listen(f"{kind}:127.0.0.1:{port}")
        check_can_listen(f"{other}:127.0.0.1:{port}")
    check_can_listen(f"{kind}:127.0.0.1:{port}")
    check_can_listen(f"{kind}:[::1]:0")


@pytest.mark.parametrize(
    "text",
    ["", "udp", "udp:14550", "tcp:host:port", "serial:/dev/x:1", "udp:host:99999", "tcpin::1", "udp:host:²"],
)
def test_invalid_ground_stations_are_refused(text: str) -> None:
    """One sentence with the string and the valid forms; nothing has been started."""
    link = FakeLink()
    with (
        pytest.raises(FlightReplayError, match=r"invalid ground station .*; write udpout:HOST:PORT"),
        ground_stations(link, ["udp:127.0.0.1:14550", text]),
    ):
        pytest.fail("it was understood")
    assert link.receivers == []


def test_every_kind_of_station_has_its_socket() -> None:
    """Upper case and IPv6 brackets are accepted."""
    for kind in ("UDPOUT", "tcp"):
        assert isinstance(socket_for(f"{kind}:[::1]:14550"), TransportSocket)
    for kind in ("udpin", "udp"):
        assert isinstance(socket_for(f"{kind}:[::1]:14550"), UdpServer)
    assert isinstance(socket_for("tcpin:127.0.0.1:0"), TcpServer)


def test_a_station_that_resets_its_connection_does_not_affect_others() -> None:
    """The others still receive every frame."""
    sockets = TcpServer(("127.0.0.1", 0))
    link = FakeLink()
    with running(GroundStation("tcpin", sockets, link.forward)) as station:
        address = ("127.0.0.1", sockets.port)
        rude, kind = (socket.create_connection(address, PATIENCE_S) for _ in range(2))
        with kind:
            for each in (rude, kind):
                each.sendall(beat())
                assert link.heard.get(timeout=PATIENCE_S) == beat()
            rude.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            rude.close()
            for number in range(10):
                station.receive(decoded(frame(number)))
            sent = b"".join(frame(number) for number in range(10))
            assert receive(kind, len(sent)) == sent


def test_a_closed_socket_cannot_be_read() -> None:
    """Reading what was never opened is an error, closing it is not."""
    sockets = TcpServer(("127.0.0.1", 0))
    sockets.close()
    with pytest.raises(OSError, match="the socket is closed"):
        sockets.read(0)


POST = b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 60\r\n\r\n"
TLS_HELLO = bytes.fromhex("16030102000100")
STRANGERS = {
    "a web page's POST": POST + beat() + command(),
    "TLS": TLS_HELLO + beat() + command(),
    "a frame that is torn": beat()[:-1] + b"x" + beat() + command(),
    "a marker and nonsense": b"\xfe\x00" + bytes(40) + beat() + command(),
}


@pytest.mark.parametrize("data", STRANGERS.values(), ids=STRANGERS.keys())
def test_who_does_not_speak_mavlink_is_disconnected(data: bytes) -> None:
    """Whatever follows, nothing of it reaches the vehicle."""
    sockets, link = TcpServer(("127.0.0.1", 0)), FakeLink()
    with (
        running(GroundStation("tcpin", sockets, link.forward)),
        socket.create_connection(("127.0.0.1", sockets.port), PATIENCE_S) as stranger,
    ):
        stranger.sendall(data)
        with suppress(ConnectionResetError):
            assert stranger.recv(1) == b""
    assert link.heard.empty()


def test_nothing_is_forwarded_before_a_ground_stations_heartbeat() -> None:
    """A command alone, or behind the heartbeat of something else, does nothing."""
    sockets, link = TcpServer(("127.0.0.1", 0)), FakeLink()
    other = dialect.MAVLink_heartbeat_message(dialect.MAV_TYPE_GIMBAL, 8, 0, 0, 4, 3)
    with (
        running(GroundStation("tcpin", sockets, link.forward)),
        socket.create_connection(("127.0.0.1", sockets.port), PATIENCE_S) as station,
    ):
        station.sendall(command() + other.pack(dialect.MAVLink(None, 1, 154)) + command())
        station.sendall(beat() + frame(9, system=255))
        assert link.heard.get(timeout=PATIENCE_S) == beat()
        assert link.heard.get(timeout=PATIENCE_S) == frame(9, system=255)


def test_a_udp_stranger_is_sent_nothing() -> None:
    """Only stations that are admitted get the vehicle's frames, so nobody can aim them at others."""
    link = FakeLink()
    with listening(socket.SOCK_DGRAM) as free:
        address = free.getsockname()
    with (
        ground_stations(link, [f"udpin:127.0.0.1:{address[1]}"]) as (station,),
        listening(socket.SOCK_DGRAM) as stranger,
        listening(socket.SOCK_DGRAM) as gcs,
    ):
        assert station.opened.wait(PATIENCE_S)
        stranger.sendto(b"hello", address)
        stranger.sendto(command(), address)
        gcs.sendto(beat(), address)
        assert link.heard.get(timeout=PATIENCE_S) == beat()
        link.speak(frame(4))
        assert gcs.recv(4096) == frame(4)
        stranger.settimeout(0.2)
        with pytest.raises(TimeoutError):
            stranger.recv(4096)
    assert link.heard.empty()


@pytest.mark.parametrize("address", ["tcpin:0.0.0.0:5760", "udpin:[::]:14550", "tcpin:example.org:1"])
def test_other_machines_are_let_in_only_when_asked_to(address: str) -> None:
    """The refusal names the option."""
    with pytest.raises(FlightReplayError, match="--gcs-open"):
        socket_for(address)
    assert socket_for(address, allow_open=True)


@pytest.mark.parametrize(
    ("address", "other_way"),
    [
        ("udp:0.0.0.0:14551", "udpout:HOST:14551"),
        ("tcpin:[::]:5760", "tcp:HOST:5760"),
        ("udp:192.0.2.7:14551", "udpout:192.0.2.7:14551"),
    ],
)
def test_a_refusal_names_where_a_station_may_listen(address: str, other_way: str) -> None:
    """All addresses of this machine are none to send to."""
    with pytest.raises(FlightReplayError, match=f"a station that listens by {other_way}$"):
        socket_for(address)


def test_connections_are_few_and_running_out_of_descriptors_drops_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One too many is closed again; while none can be accepted, the others are served."""
    sockets, link = TcpServer(("127.0.0.1", 0)), FakeLink()
    with running(GroundStation("tcpin", sockets, link.forward)) as station, ExitStack() as stack:
        address = ("127.0.0.1", sockets.port)
        made = [
            stack.enter_context(socket.create_connection(address, PATIENCE_S)) for _ in range(MAX_CONNECTIONS)
        ]
        for each in made:
            each.sendall(beat())
            assert link.heard.get(timeout=PATIENCE_S) == beat()
        extra = stack.enter_context(socket.create_connection(address, PATIENCE_S))
        assert extra.recv(1) == b""

        def accept() -> None:
            raise OSError(errno.EMFILE, "too many open files")

        monkeypatch.setattr(socket.socket, "accept", lambda _: accept())
        stack.enter_context(socket.create_connection(address, PATIENCE_S))
        station.receive(decoded(frame(5)))
        assert receive(made[0], len(frame(5))) == frame(5)


@contextmanager
def opened() -> Iterator[TcpServer]:
    """A server that is read by the test itself."""
    server = TcpServer(("127.0.0.1", 0))
    server.open()
    try:
        yield server
    finally:
        server.close()


def test_without_descriptors_the_server_rests_and_tries_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """The connection that waits does not keep it busy; it is accepted once that is possible."""
    monkeypatch.setattr("flight_replay.vehicle.link.ground_station_servers._RETRY_ACCEPT_S", 0.4)

    def fail(_: socket.socket) -> None:
        raise OSError(errno.EMFILE, "too many open files")

    with opened() as server, socket.create_connection(("127.0.0.1", server.port), PATIENCE_S) as late:
        with monkeypatch.context() as patch:
            patch.setattr(socket.socket, "accept", fail)
            server.read(PATIENCE_S)
        began_s = time.monotonic()
        assert server.read(0.2) == []
        assert time.monotonic() - began_s > 0.1
        late.sendall(beat())
        end_s = time.monotonic() + PATIENCE_S
        while not (received := server.read(0.05)) and time.monotonic() < end_s:
            pass
        assert [data for _, data in received] == [beat()]


def test_a_station_that_does_not_read_is_disconnected(monkeypatch: pytest.MonkeyPatch) -> None:
    """The other one gets every frame."""
    monkeypatch.setattr("flight_replay.vehicle.link.ground_station_servers._SEND_S", 0.1)
    with opened() as server, ExitStack() as stack:
        idle, reader = (
            stack.enter_context(socket.create_connection(("127.0.0.1", server.port), PATIENCE_S))
            for _ in range(2)
        )
        for _ in range(2):
            server.read(PATIENCE_S)
        piece = bytes(1 << 20)
        for _ in range(100):
            sender = threading.Thread(target=server.write, args=(piece,), daemon=True)
            sender.start()
            assert receive(reader, len(piece)) == piece
            sender.join(PATIENCE_S)
            assert not sender.is_alive(), "it waits for the one that does not read"
        assert len(server._stations) == 1
        assert idle.fileno() >= 0


def test_no_error_ends_a_stations_thread() -> None:
    """Not even one that nobody foresaw, of the link to the vehicle: the station is heard again."""
    errors: list[type[Exception]] = [RuntimeError, MemoryError]

    class Failing(FakeLink):
        def forward(self, frame: bytes) -> None:
            if errors:
                raise errors.pop()
            super().forward(frame)

    link = Failing()
    with (
        listening(socket.SOCK_STREAM) as gcs,
        ground_stations(link, [f"tcp:127.0.0.1:{gcs.getsockname()[1]}"]),
    ):
        for _ in range(3):
            connection, _ = gcs.accept()
            with connection:
                fails = bool(errors)
                connection.sendall(command())
                if not fails:
                    assert link.heard.get(timeout=PATIENCE_S) == command()
                    break
                assert connection.recv(1) == b""


def test_half_begun_strangers_are_forgotten() -> None:
    """However many send a marker and nothing more, a few are remembered, and a station gets through."""
    link = FakeLink()
    with listening(socket.SOCK_DGRAM) as free:
        address = free.getsockname()
    with ground_stations(link, [f"udpin:127.0.0.1:{address[1]}"]) as (station,), ExitStack() as stack:
        assert station.opened.wait(PATIENCE_S)
        for _ in range(3 * MAX_SENDERS):
            stranger = stack.enter_context(listening(socket.SOCK_DGRAM))
            stranger.sendto(b"\xfd", address)
        gcs = stack.enter_context(listening(socket.SOCK_DGRAM))
        gcs.sendto(beat(), address)
        assert link.heard.get(timeout=PATIENCE_S) == beat()
        assert len(station._admissions) <= MAX_SENDERS


@pytest.mark.parametrize(
    ("connection", "stations"),
    [
        ("127.0.0.1:14550", ["udp:localhost:14550"]),
        ("udp::14550", ["udpin:127.0.0.1:14550"]),
        ("udpin:0.0.0.0:14550", ["tcp:127.0.0.1:5762", "udpout:[::1]:14550"]),
        ("tcp:127.0.0.1:5760", ["tcp:127.0.0.1:5760"]),
        (None, ["udpout:10.0.0.2:14550", "udpout:10.0.0.2:14550"]),
    ],
)
def test_an_address_used_twice_is_refused(connection: str | None, stations: list[str]) -> None:
    """Frames would go round in circles."""
    with pytest.raises(FlightReplayError, match="is used twice"):
        check_distinct(connection, stations)


def test_this_machines_address_on_the_network_is_this_machine() -> None:
    """A vehicle's port that listens on all addresses is reached by it too."""
    with pytest.raises(FlightReplayError, match="is used twice"):
        check_distinct("udpin:0.0.0.0:14550", [f"udp:{outside_address()}:14550"])


def test_different_addresses_may_be_used_together() -> None:
    """Other ports, other hosts, other protocols, and a serial port."""
    check_distinct("127.0.0.1:14550", ["udp:127.0.0.1:14551", "tcp:127.0.0.1:14550", "udp:10.0.0.2:14550"])
    check_distinct("/dev/ttyUSB0,57600", ["udp:127.0.0.1:14550"])

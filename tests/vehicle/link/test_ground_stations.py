"""gcs.py and gcs_sockets.py: ground stations that watch and may act."""

from __future__ import annotations

import queue
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as dialect

from flight_replay.errors import FlightReplayError
from flight_replay.vehicle.link.ground_station_sockets import TcpServer, TransportSocket, socket_for
from flight_replay.vehicle.link.ground_stations import QUEUED_FRAMES, GroundStation, ground_stations

PATIENCE_S = 10.0


class FakeLink:
    """A link whose vehicle speaks when told to, and whose ears are a queue."""

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


@pytest.mark.parametrize("kind", ["udp", "udpout"])
def test_a_station_that_listens_on_udp_gets_every_frame_and_is_obeyed(kind: str) -> None:
    """The vehicle's frames go out byte for byte, the station's command goes in byte for byte."""
    link = FakeLink()
    with listening(socket.SOCK_DGRAM) as station:
        with ground_stations(link, [f"{kind}:127.0.0.1:{station.getsockname()[1]}"]):
            link.speak(frame(1))
            data, sender = station.recvfrom(4096)
            assert data == frame(1)
            station.sendto(command(), sender)
            assert link.heard.get(timeout=PATIENCE_S) == command()
        assert link.receivers == []


def test_a_station_that_speaks_first_on_udp_is_answered() -> None:
    """``udpin`` learns who is there from who speaks."""
    with listening(socket.SOCK_DGRAM) as free:
        address = free.getsockname()
    link = FakeLink()
    with (
        ground_stations(link, [f"udpin:127.0.0.1:{address[1]}"]) as (station,),
        listening(socket.SOCK_DGRAM) as gcs,
    ):
        assert station.opened.wait(PATIENCE_S)
        gcs.sendto(command(), address)
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


def test_two_stations_that_connect_by_tcp_both_watch_and_their_bytes_never_mix() -> None:
    """Half a command of one station and a whole one of another arrive as two whole commands."""
    sockets = TcpServer(("127.0.0.1", 0))
    link = FakeLink()
    with running(GroundStation("tcpin", sockets, link.forward)) as station:
        address = ("127.0.0.1", sockets.port)
        with (
            socket.create_connection(address, PATIENCE_S) as one,
            socket.create_connection(address, PATIENCE_S) as two,
        ):
            one.sendall(command()[:10])
            two.sendall(frame(7, system=255))
            assert link.heard.get(timeout=PATIENCE_S) == frame(7, system=255)
            one.sendall(command()[10:])
            assert link.heard.get(timeout=PATIENCE_S) == command()
            station.receive(decoded(frame(3)))
            assert receive(one, len(frame(3))) == receive(two, len(frame(3))) == frame(3)
        with socket.create_connection(address, PATIENCE_S) as late:
            late.sendall(command())
            assert link.heard.get(timeout=PATIENCE_S) == command()


def test_a_stream_that_breaks_is_opened_again() -> None:
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


def test_what_was_queued_at_the_end_still_goes_out() -> None:
    """The last frames before closing reach the station."""
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


def test_a_station_that_is_not_there_holds_nothing_up() -> None:
    """Frames queue up to a bound, the oldest are forgotten, and closing is quick."""
    with listening(socket.SOCK_DGRAM) as nobody:
        port = nobody.getsockname()[1]
    link = FakeLink()
    with ground_stations(link, [f"tcp:127.0.0.1:{port}", f"udp:127.0.0.1:{port}"]) as (stream, _):
        for number in range(QUEUED_FRAMES + 100):
            link.speak(frame(number))
        assert len(stream._queue) == QUEUED_FRAMES


@pytest.mark.parametrize(
    "text", ["", "udp", "udp:14550", "tcp:host:port", "serial:/dev/x:1", "udp:host:99999", "tcpin::1"]
)
def test_strings_that_name_no_station_are_told(text: str) -> None:
    """One sentence names the string and how to write one; nothing has been started."""
    link = FakeLink()
    with (
        pytest.raises(FlightReplayError, match=r"invalid ground station .*; write udp:HOST:PORT"),
        ground_stations(link, ["udp:127.0.0.1:14550", text]),
    ):
        pytest.fail("it was understood")
    assert link.receivers == []


def test_every_kind_of_station_has_its_socket() -> None:
    """Upper case and IPv6 brackets do no harm."""
    for kind in ("udp", "UDPOUT", "udpin", "tcp"):
        assert isinstance(socket_for(f"{kind}:[::1]:14550"), TransportSocket)
    assert isinstance(socket_for("tcpin:127.0.0.1:0"), TcpServer)


def test_a_station_that_breaks_off_does_not_disturb_the_others() -> None:
    """A connection that is reset is forgotten; frames go on to who is there."""
    sockets = TcpServer(("127.0.0.1", 0))
    link = FakeLink()
    with running(GroundStation("tcpin", sockets, link.forward)) as station:
        address = ("127.0.0.1", sockets.port)
        rude, kind = (socket.create_connection(address, PATIENCE_S) for _ in range(2))
        with kind:
            for each in (rude, kind):
                each.sendall(command())
                assert link.heard.get(timeout=PATIENCE_S) == command()
            rude.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            rude.close()
            for number in range(10):
                station.receive(decoded(frame(number)))
            sent = b"".join(frame(number) for number in range(10))
            assert receive(kind, len(sent)) == sent


def test_a_closed_socket_says_so() -> None:
    """Reading what was never opened is an error, closing it none."""
    sockets = TcpServer(("127.0.0.1", 0))
    sockets.close()
    with pytest.raises(OSError, match="the socket is closed"):
        sockets.read(0)

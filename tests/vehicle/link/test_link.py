"""The link sends heartbeats, reconnects, and delivers every message."""

from __future__ import annotations

import queue
import socket
import time
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from flight_replay.exceptions import LinkFaultError
from flight_replay.logs.tlog.writer import Recorder
from flight_replay.mavlink import dialect, robust_parser, source_of
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.frame_parser import ParserPool
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.link.link_faults import LinkFaults
from flight_replay.vehicle.link.own_ids import OUR_COMPONENT, OUR_SYSTEM
from flight_replay.vehicle.link.transport import TcpClient
from flight_replay.vehicle.link.vehicle_link import DroneKitLink


class Vehicle:
    """The other end of a TCP link."""

    def __init__(self) -> None:
        self.server = socket.create_server(("127.0.0.1", 0))
        self.server.settimeout(60)
        self.mav = dialect.MAVLink(None, 1, 1)
        self.parser = robust_parser()
        self.client: socket.socket | None = None
        self.links: list[Link] = []

    @property
    def address(self) -> tuple[str, int]:
        host, port = self.server.getsockname()[:2]
        return host, port

    def linked(self, **options: Any) -> Link:
        """A link to it, which is closed after the test."""
        transport = TcpClient(self.address)
        transport.open()
        self.accept()
        link = Link(transport, **options)
        self.links.append(link)
        link.start()
        return link

    def accept(self) -> None:
        if self.client:
            self.client.close()
        self.client, _ = self.server.accept()
        self.client.settimeout(60)

    def send(self, message: Any, *, old: bool = False) -> None:
        assert self.client
        self.client.sendall(message.pack(self.mav, force_mavlink1=old))

    def heard(self, count: int) -> list[Any]:
        """The next messages that come."""
        assert self.client
        messages: list[Any] = []
        while len(messages) < count:
            data = self.client.recv(4096)
            assert data, "the link was closed"
            messages += self.parser.parse_buffer(data) or []
        return messages

    def version_of_ping(self) -> int:
        """The first byte, which tells the version, of the PING that comes."""
        while True:
            for message in self.heard(1):
                if message.get_type() == "PING":
                    return int(message.get_msgbuf()[0])

    def close(self) -> None:
        if self.client:
            self.client.close()
        self.server.close()

    def end(self) -> None:
        """Close the links to it, and it."""
        for link in self.links:
            link.close()
        self.close()


@pytest.fixture
def vehicle() -> Iterator[Vehicle]:
    vehicle = Vehicle()
    yield vehicle
    vehicle.end()


def heard_on(link: Link) -> queue.SimpleQueue[Any]:
    """The messages that a link receives from now on."""
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
    link.add_receiver(heard.put)
    return heard


BEAT = dialect.MAVLink_heartbeat_message(2, 3, 0, 0, 3, 3)
PING = dialect.MAVLink_ping_message(1, 2, 1, 1)


def test_heartbeats_are_sent_often_enough(vehicle: Vehicle) -> None:
    """At speedup 20 at least 20 a second: one a second of vehicle time."""
    vehicle.linked(speedup=20.0)
    began_s = time.monotonic()
    beats = vehicle.heard(21)
    assert time.monotonic() - began_s < 10.0
    assert {(m.get_srcSystem(), m.get_srcComponent()) for m in beats} == {(OUR_SYSTEM, OUR_COMPONENT)}
    assert {m.type for m in beats} == {dialect.MAV_TYPE_GCS}


def test_mavlink_1_is_sent_until_the_vehicle_sends_mavlink_2(vehicle: Vehicle) -> None:
    """ArduCopter 3.3 understands nothing else."""
    link = vehicle.linked()
    link.follow(1, 1)
    heard = heard_on(link)
    vehicle.heard(1)
    vehicle.send(BEAT, old=True)
    heard.get(timeout=60)
    link.send(BEAT)
    assert vehicle.heard(1)[0].get_msgbuf()[0] == 0xFE
    vehicle.send(BEAT)
    heard.get(timeout=60)
    link.send(BEAT)
    assert vehicle.heard(1)[0].get_msgbuf()[0] == 0xFD


@pytest.mark.parametrize("followed", [False, True], ids=["before it is followed", "in flight"])
def test_mavlink_2_of_another_station_does_not_count(vehicle: Vehicle, followed: bool) -> None:
    """A vehicle that understands MAVLink 1 only would hear no command any more, RTL included."""
    link = vehicle.linked()
    heard = heard_on(link)
    vehicle.heard(1)
    if followed:
        link.follow(1, 1)
    for system, component in ((250, 190), (1, 191), (2, 1)):
        vehicle.mav.srcSystem, vehicle.mav.srcComponent = system, component
        vehicle.send(BEAT)
        heard.get(timeout=60)
    link.follow(1, 1)
    link.send(PING)
    assert vehicle.version_of_ping() == 0xFE
    assert not link.vehicle_sends_mavlink2


def test_mavlink_2_can_be_offered(vehicle: Vehicle) -> None:
    """A port that begins with MAVLink 1 may go on with MAVLink 2 once it hears some; until then we do not."""
    link = vehicle.linked()
    link.follow(1, 1)
    link.offer_mavlink2()
    versions: list[int] = []
    while 0xFD not in versions:
        versions += [message.get_msgbuf()[0] for message in vehicle.heard(1)]
    link.send(PING)
    assert vehicle.version_of_ping() == 0xFE


def test_mavlink_2_is_sent_at_once_to_a_vehicle_that_was_heard_in_it(vehicle: Vehicle) -> None:
    """Before it was followed."""
    link = vehicle.linked()
    heard = heard_on(link)
    vehicle.heard(1)
    vehicle.send(BEAT)
    heard.get(timeout=60)
    link.follow(1, 1)
    link.send(PING)
    assert vehicle.version_of_ping() == 0xFD


def test_receivers_of_the_vehicle_hear_no_others(vehicle: Vehicle) -> None:
    """Neither a gimbal with the vehicle's system id nor another vehicle."""
    link = vehicle.linked()
    link.follow(1, 1)
    heard = heard_on(link)
    of_vehicle: list[Any] = []
    link.add_receiver(of_vehicle.append, of_vehicle=True)
    for system, component in ((1, 1), (1, 154), (2, 1), (1, 1)):
        vehicle.mav.srcSystem, vehicle.mav.srcComponent = system, component
        vehicle.send(BEAT)
    for _ in range(4):
        heard.get(timeout=60)
    link.close()
    assert [source_of(message) for message in of_vehicle] == [(1, 1), (1, 1)]


def test_the_answer_to_a_ping_measures_the_round_trip(vehicle: Vehicle) -> None:
    """Whoever sent it does not have to wait for it."""
    link = vehicle.linked()
    link.follow(1, 1)
    to_vehicle = DroneKitLink(link, SimpleNamespace(send_mavlink=link.send), 1, 1)
    heard = heard_on(link)
    unmeasured_s = to_vehicle.round_trip.median_s
    stamp_ns = timesync.ping(to_vehicle)
    time.sleep(0.1)
    vehicle.send(dialect.MAVLink_timesync_message(7, stamp_ns))
    heard.get(timeout=60)
    assert to_vehicle.round_trip.median_s >= 0.1
    assert to_vehicle.round_trip.median_s != unmeasured_s


def test_a_closed_connection_is_reopened(vehicle: Vehicle) -> None:
    """When the vehicle closes the connection, the link reconnects; what is sent meanwhile is lost."""
    link = vehicle.linked()
    heard = heard_on(link)
    vehicle.heard(1)
    assert vehicle.client
    vehicle.client.close()
    vehicle.accept()
    vehicle.send(BEAT)
    assert heard.get(timeout=60).get_type() == "HEARTBEAT"
    vehicle.heard(1)


def test_a_link_without_a_vehicle_can_be_closed(vehicle: Vehicle) -> None:
    """Also while it tries to connect again."""
    link = vehicle.linked()
    vehicle.close()
    link.send(BEAT)
    link.send(BEAT)
    began_s = time.monotonic()
    link.close()
    assert time.monotonic() - began_s < 10.0


def test_an_error_in_a_receiver_does_not_stop_the_link(
    vehicle: Vehicle, caplog: pytest.LogCaptureFixture
) -> None:
    """It is logged; the next receiver and the next message are served; removed receivers are not."""
    link = vehicle.linked()
    heard: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def fail(message: Any) -> None:
        raise RuntimeError("no")

    link.add_receiver(fail)
    link.add_receiver(heard.put)
    vehicle.send(BEAT)
    heard.get(timeout=60)
    link.remove_receiver(fail)
    vehicle.send(BEAT)
    heard.get(timeout=60)
    link.close()
    assert [record.message for record in caplog.records if record.levelname == "ERROR"] == [
        "cannot process HEARTBEAT"
    ]


def test_one_message_that_cannot_be_processed_is_skipped(
    vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those that came with it are not."""

    def fail_on_pings(link: Link, message: Any, frame: bytes) -> bool:
        if message.get_type() == "PING":
            raise ValueError("no")
        return True

    monkeypatch.setattr(Link, "_is_of_one_vehicle", fail_on_pings)
    link = vehicle.linked()
    heard = heard_on(link)
    assert vehicle.client
    vehicle.client.sendall(b"".join(each.pack(vehicle.mav) for each in (PING, BEAT)))
    assert heard.get(timeout=60).get_type() == "HEARTBEAT"
    assert link.faults.first.startswith("cannot process PING: internal error (ValueError: no)")


@pytest.mark.parametrize("needed", [True, False])
def test_the_vehicle_is_not_heard_while_a_receiver_that_is_needed_fails(
    vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch, needed: bool
) -> None:
    """What another does, such as a display, is nothing to the flight."""
    monkeypatch.setattr("flight_replay.vehicle.link.link_faults._LASTING_S", 0.0)
    link = vehicle.linked()
    link.follow(1, 1)

    def fail(message: Any) -> None:
        raise SystemExit("no")

    link.add_receiver(fail, of_vehicle=True, needed=needed)
    heard = heard_on(link)
    for _ in range(3):
        vehicle.send(BEAT)
    for _ in range(3):
        heard.get(timeout=60)
    link.close()
    with pytest.raises(LinkFaultError) if needed else nullcontext():
        link.faults.check()
    assert link.faults.first


def test_whoever_waits_for_an_answer_is_told_that_none_can_come(vehicle: Vehicle) -> None:
    """As soon as that is known: parameters and missions are waited for longer than a flight can wait."""
    link = vehicle.linked()
    link.faults = LinkFaults(iter(range(9)).__next__)
    with DroneKitLink(link, None, 1, 1).inbox("PARAM_VALUE") as inbox:
        assert inbox.get(0.0) is None
        for _ in range(3):
            link.faults.note("read the link", ValueError("no"))
        with pytest.raises(LinkFaultError, match="nothing is heard from the vehicle"):
            inbox.get(0.0)


def test_junk_between_messages_is_skipped(vehicle: Vehicle) -> None:
    """Bytes that are not a frame are ignored."""
    link = vehicle.linked()
    heard = heard_on(link)
    assert vehicle.client
    vehicle.client.sendall(b"PreArm junk\r\n")
    for _ in range(3):
        vehicle.send(BEAT)
    assert heard.get(timeout=60).get_type() == "HEARTBEAT"


def test_both_directions_are_recorded(vehicle: Vehicle, tmp_path: Path) -> None:
    """The log has what the vehicle, this program and a ground station on the link sent."""
    with Recorder(tmp_path / "flight.tlog") as recorder:
        link = vehicle.linked(recorder=recorder)
        heard = heard_on(link)
        vehicle.heard(1)
        vehicle.send(BEAT)
        heard.get(timeout=60)
        link.forward(dialect.MAVLink_system_time_message(1, 2).pack(dialect.MAVLink(None, 255, 190)))
        vehicle.heard(1)
        link.close()
    data = (tmp_path / "flight.tlog").read_bytes()
    parser = dialect.MAVLink(None)
    senders = []
    while data:
        length = 12 + data[9] if data[8] == 0xFD else 8 + data[9]
        (message,) = parser.parse_buffer(data[8 : 8 + length])
        senders.append((message.get_srcSystem(), message.get_srcComponent()))
        data = data[8 + length :]
    assert {(255, OUR_COMPONENT), (1, 1), (255, 190)} <= set(senders)


def test_a_silent_tcp_connection_is_reopened(vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch) -> None:
    """After seconds without data, even if its socket reports no error."""
    monkeypatch.setattr("flight_replay.vehicle.link.link._SILENT_S", 0.5)
    vehicle.linked(speedup=20.0)
    vehicle.heard(1)
    vehicle.accept()
    vehicle.heard(1)


class BrokenTransport:
    """A transport that raises what it is told to when it is read, written to, or both; it carries nothing."""

    sender: Any = None
    reopen_if_silent = False

    def __init__(self, error: type[Exception], calls: tuple[str, ...]) -> None:
        self.error, self.calls = error, calls
        self.opened = self.written = 0
        self.fails = True

    def open(self) -> None:
        self.opened += 1
        if self.opened < 2:
            raise self.error("gone")
        self.fails = False

    def read(self, timeout_s: float) -> bytes:
        if self.fails and "read" in self.calls:
            raise self.error("gone")
        time.sleep(timeout_s)
        return b""

    def write(self, data: bytes) -> None:
        if self.fails and "write" in self.calls:
            raise self.error("gone")
        self.written += not self.fails

    def send_only_to(self, sender: Any) -> None:
        return

    def close(self) -> None:
        return


@pytest.mark.parametrize("calls", [("read",), ("write",), ("read", "write")], ids="+".join)
@pytest.mark.parametrize("error", [OSError, AttributeError, TypeError, ValueError, RuntimeError, MemoryError])
def test_whatever_a_transport_raises_it_is_reopened(error: type[Exception], calls: tuple[str, ...]) -> None:
    """Senders get no exception, and frames go out again once the transport opens."""
    transport = BrokenTransport(error, calls)
    link = Link(transport)
    link.send(BEAT)
    link.start()
    try:
        end_s = time.monotonic() + 20
        while not transport.written and time.monotonic() < end_s:
            time.sleep(0.02)
        assert transport.opened == 2
        assert transport.written
    finally:
        link.close()


def test_a_recorder_that_fails_does_not_disturb_the_link(vehicle: Vehicle) -> None:
    """Neither the sender nor the link's thread, which receives on, notices its error; its problem is kept."""

    class Broken(Recorder):
        def __init__(self) -> None:
            self.asked = 0

        def write(self, frame: bytes) -> None:
            self.asked += 1
            raise RuntimeError("no")

    recorder = Broken()
    link = vehicle.linked(recorder=recorder)
    heard = heard_on(link)
    link.send(BEAT)
    assert vehicle.heard(2)
    for _ in range(2):
        vehicle.send(BEAT)
        assert heard.get(timeout=20).get_type() == "HEARTBEAT"
    link.close()
    assert recorder.asked >= 4
    assert recorder.problem == "a frame was not recorded: no"


def test_no_error_ends_the_links_thread(vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not even one that nobody foresaw, such as of the parser: it is the only way to the vehicle."""
    errors: list[type[BaseException]] = [RecursionError, MemoryError, KeyError, SystemExit]
    messages = ParserPool.messages

    def fail(self: ParserPool, data: bytes, sender: object) -> Any:
        if data and errors:
            raise errors.pop()
        return messages(self, data, sender)

    monkeypatch.setattr(ParserPool, "messages", fail)
    monkeypatch.setattr("flight_replay.vehicle.link.link._REOPEN_S", 0.01)
    link = vehicle.linked()
    heard = heard_on(link)
    end_s = time.monotonic() + 20
    while heard.empty() and time.monotonic() < end_s:
        vehicle.send(BEAT)
        time.sleep(0.02)
    assert heard.get(timeout=1).get_type() == "HEARTBEAT"
    assert not errors

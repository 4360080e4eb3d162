"""Two vehicles with one system id: only one is listened to and sent to; a vehicle that moves is followed."""

from __future__ import annotations

from collections import deque
from typing import Any

import pytest

from flight_replay.mavlink import dialect
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.link.vehicle_sender import BOTH_S, SILENT_S, VehicleSender

A, B = ("10.0.0.1", 14550), ("10.0.0.2", 14550)


class Heard:
    """A sender that frames come from at given times, each frame another one."""

    def __init__(self) -> None:
        self.sender, self.count = VehicleSender(), 0

    def frame(self, address: Any, now_s: float) -> bool:
        """Whether a new frame is the vehicle's."""
        self.count += 1
        return self.sender.accepts(address, b"%d" % self.count, now_s)

    def both(self, begin_s: float, seconds: float) -> None:
        """Both send a heartbeat twice a second."""
        for half in range(int(2 * seconds) + 1):
            self.frame(A, begin_s + half / 2)
            self.frame(B, begin_s + half / 2)


def test_of_two_that_are_heard_the_first_is_the_vehicle() -> None:
    """Frames of the other are dropped, and it is told."""
    heard = Heard()
    assert heard.frame(A, 0.0)
    assert not heard.frame(B, 0.1)
    assert not heard.sender.rival
    heard.both(0.5, 2.0)
    assert [heard.sender.address, heard.sender.rival] == [A, B]


def test_a_vehicle_whose_address_changes_is_followed() -> None:
    """Once nothing comes from the old one; packets that are late do not matter."""
    heard = Heard()
    assert heard.frame(A, 0.0)
    assert not heard.frame(B, 0.5)
    assert heard.frame(A, 0.5 + BOTH_S / 2)
    assert not heard.frame(B, SILENT_S)
    assert heard.frame(B, 0.6 + BOTH_S / 2 + SILENT_S)
    assert (heard.sender.address, heard.sender.rival) == (B, None)


def test_another_vehicle_is_never_followed() -> None:
    """However long the vehicle that is flown is silent: the other would confirm RTL in its place."""
    heard = Heard()
    heard.both(0.0, 2.0)
    assert not heard.frame(B, 100.0)
    assert heard.sender.address == A
    assert heard.frame(A, 200.0)


def test_the_vehicle_that_was_first_is_returned_to() -> None:
    """Another one that was first heard in a gap of its link is dropped when it is back."""
    heard = Heard()
    heard.frame(A, 0.0)
    assert heard.frame(B, 3.0)
    assert heard.frame(A, 3.5)
    assert not heard.frame(B, 4.0)
    assert heard.frame(A, 4.5)
    assert (heard.sender.address, heard.sender.rival) == (A, B)


def test_a_vehicle_that_is_heard_by_two_ways_is_one() -> None:
    """Its frames are the same; the other way is taken when the first is silent."""
    sender = VehicleSender()
    for count in range(20):
        ways = (A, B) if count % 2 else (B, A)
        for way in (A, B) if count == 0 else ways:
            assert sender.accepts(way, b"%d" % count, count / 4) == (way == A)
    assert sender.rival is None
    assert sender.accepts(B, b"alone", 5.0 + SILENT_S)


def test_heartbeats_that_happen_to_be_equal_hide_nothing_for_long() -> None:
    """Sequence numbers go up to 255 only."""
    heard = Heard()
    heard.both(0.0, 0.5)
    assert heard.sender.accepts(A, b"the same", 0.8)
    assert not heard.sender.accepts(B, b"the same", 0.9)
    heard.both(1.0, 2.0)
    assert heard.sender.rival == B


def test_a_flood_of_addresses_is_bounded() -> None:
    heard = Heard()
    heard.frame(A, 0.0)
    for number in range(1000):
        heard.frame(("10.0.1.1", number), 0.1 + number / 1e4)
        heard.frame(A, 0.1 + number / 1e4)
    for number in range(1000):
        heard.frame(("10.0.2.2", number), 10.0 + 3.0 * number)
    sender = heard.sender
    assert max(map(len, (sender._others, sender._rivals, sender._earlier, sender._frames))) <= 64


class Datagrams:
    """A transport with datagrams that came from given addresses, and the address that is sent to."""

    reopen_if_silent = False

    def __init__(self) -> None:
        self.waiting: deque[tuple[Any, bytes]] = deque()
        self.sender: Any = None
        self.sent_to: Any = None

    def read(self, timeout_s: float) -> bytes:
        self.sender, data = self.waiting.popleft()
        return data

    def send_only_to(self, sender: Any) -> None:
        self.sent_to = sender

    def open(self) -> None: ...

    def write(self, data: bytes) -> None: ...

    def close(self) -> None: ...


@pytest.mark.parametrize("address", [B, ("::1", 14550, 0, 0)], ids=["IPv4", "IPv6"])
def test_a_link_takes_messages_from_one_vehicle_only(address: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """And sends to that; its other components may have addresses of their own."""
    monkeypatch.setattr("flight_replay.vehicle.link.vehicle_sender.BOTH_S", 0.0)
    transport = Datagrams()
    link, received = Link(transport), list[tuple[int, int]]()
    link.add_receiver(lambda message: received.append((message.custom_mode, message.get_srcComponent())))

    def beat(sender: Any, mode: int, component: int = 1) -> None:
        message = dialect.MAVLink_heartbeat_message(2, 3, 0, mode, 3, 3)
        transport.waiting.append((sender, message.pack(dialect.MAVLink(None, 1, component))))
        link._receive(0.0)

    beat(A, 4)
    link.follow(1, 1)
    assert link.both_senders is None
    beat(address, 0)
    beat(address, 9, component=191)
    beat(A, 5)
    beat(address, 0)
    assert received == [(4, 1), (9, 191), (5, 1)]
    assert transport.sent_to == A
    assert link.both_senders == ("10.0.0.1:14550", "[::1]:14550" if address != B else "10.0.0.2:14550")

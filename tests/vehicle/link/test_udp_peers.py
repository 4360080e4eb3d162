"""Whom a listening UDP link sends to: a few recent peers, then the vehicle alone."""

from __future__ import annotations

import queue
import socket
import threading
import time

from flight_replay.mavlink import dialect
from flight_replay.vehicle.link.frame_parser import MAX_SENDERS, ParserPool
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.link.transport import UdpListener
from flight_replay.vehicle.link.udp_peers import EXPIRY_S, MAX_PEERS, UdpPeers

BEAT = dialect.MAVLink_heartbeat_message(2, 3, 0, 0, 3, 3)


def test_the_latest_peers_are_kept() -> None:
    """However many come, a bounded number stays, and those are the latest."""
    peers = UdpPeers()
    for port in range(1000):
        peers.received(("127.0.0.1", port), 1.0)
    assert peers.addresses == tuple(("127.0.0.1", port) for port in range(1000 - MAX_PEERS, 1000))


def test_a_silent_peer_is_forgotten() -> None:
    """Until it sends again."""
    peers = UdpPeers()
    peers.received("a", 0.0)
    peers.received("b", 0.9 * EXPIRY_S)
    assert peers.addresses == ("a", "b")
    peers.received("b", 1.1 * EXPIRY_S)
    assert "a" not in peers.addresses
    peers.received("a", 1.2 * EXPIRY_S)
    assert peers.addresses == ("b", "a")


def test_once_it_is_known_the_vehicle_alone_is_sent_to() -> None:
    """Also after others sent, and after its address changed."""
    peers = UdpPeers()
    peers.received("other", 0.0)
    peers.send_only_to("vehicle")
    for now_s in (1.0, 100.0):
        peers.received("other", now_s)
        peers.received("vehicle", now_s)
        assert peers.addresses == ("vehicle",)
    peers.send_only_to("moved")
    assert peers.addresses == ("moved",)


def test_frames_of_several_senders_do_not_mix() -> None:
    """A frame torn over two datagrams is put together from its own sender's bytes; parsers stay few."""
    frame = BEAT.pack(dialect.MAVLink(None, 1, 1))
    pool = ParserPool()
    assert list(pool.messages(frame[:5], "vehicle")) == []
    assert list(pool.messages(b"\xfd\xff\x00junk", "other")) == []
    assert [m.get_type() for m in pool.messages(frame[5:], "vehicle")] == ["HEARTBEAT"]
    for sender in range(10 * MAX_SENDERS):
        list(pool.messages(b"\xfd", sender))
    assert len(pool._parsers) == MAX_SENDERS


def test_a_flood_of_senders_leaves_the_link_to_the_vehicle() -> None:
    """Thousands of one-datagram senders while others send: no error; answers go to the vehicle alone."""
    listener = UdpListener(("127.0.0.1", 0))
    listener.open()
    address = listener._open_socket.getsockname()
    link = Link(listener)
    link.follow(1, 1)
    link.start()
    errors: list[BaseException] = []
    stop = threading.Event()

    def send() -> None:
        try:
            while not stop.is_set():
                link.send(BEAT)
        except BaseException as error:
            errors.append(error)

    sender = threading.Thread(target=send)
    sender.start()
    try:
        with (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle,
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stays,
        ):
            vehicle.settimeout(60)
            vehicle.bind(("127.0.0.1", 0))
            encoder = dialect.MAVLink(None, 1, 1)
            for _ in range(1500):
                with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
                    stranger.sendto(b"x", address)
            end_s = time.monotonic() + 20
            ports = [vehicle.getsockname()[1]]
            while [peer[1] for peer in listener._peers.addresses] != ports and time.monotonic() < end_s:
                stays.sendto(b"x", address)
                vehicle.sendto(BEAT.pack(encoder), address)
                time.sleep(0.05)
            assert vehicle.recv(4096)
            heard: queue.SimpleQueue[int] = queue.SimpleQueue()
            link.add_receiver(lambda message: heard.put(message.get_srcSystem()))
            stays.sendto(BEAT.pack(dialect.MAVLink(None, 2, 1)), address)
            while heard.get(timeout=20) != 2:
                pass
            assert [peer[1] for peer in listener._peers.addresses] == ports
    finally:
        stop.set()
        sender.join()
        link.close()
    assert not errors

"""MAVLink 2 signing: pymavlink's own signatures and ours agree, and nobody else is heeded."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavutil

from flight_replay.exceptions import VehicleError
from flight_replay.logs.tlog.writer import Recorder
from flight_replay.mavlink import dialect
from flight_replay.vehicle.link.signing import (
    Signing,
    is_readable_by_others,
    is_signed,
    read_key,
    without_signature,
)
from tests.vehicle.link.test_link import BEAT, Vehicle, heard_on

KEY = hashlib.sha256(b"a passphrase").digest()
NOW_S = 1_800_000_000.0
NOW = int((NOW_S - 1_420_070_400) * 1e5)


def signer(key: bytes = KEY, *, timestamp: int = NOW, system: int = 1) -> Any:
    """pymavlink as the other end of a signed link."""
    mav = dialect.MAVLink(None, system, 1)
    mav.robust_parsing = True
    mav.signing.secret_key, mav.signing.timestamp = key, timestamp
    mav.signing.sign_outgoing, mav.signing.link_id = True, 3
    return mav


def signing() -> Signing:
    return Signing(KEY, clock_s=lambda: NOW_S)


def parsed(mav: Any, data: bytes) -> list[str]:
    return [message.get_type() for message in mav.parse_buffer(data) or []]


@pytest.mark.parametrize("content", [KEY.hex(), KEY.hex().upper() + "\n", "a passphrase", "a passphrase\r\n"])
def test_a_key_is_hexadecimal_or_a_passphrase(tmp_path: Path, content: str) -> None:
    """A passphrase is hashed with SHA-256, as in Mission Planner and MAVProxy."""
    path = tmp_path / "key"
    path.write_bytes(content.encode())
    assert read_key(path) == KEY


def test_a_key_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    """Missing, a folder, empty, or binary: no other key is made of it."""
    with pytest.raises(VehicleError, match=r"cannot read the signing key .*: No such file"):
        read_key(tmp_path / "none")
    with pytest.raises(VehicleError, match=r"cannot read the signing key .*: Is a directory"):
        read_key(tmp_path)
    (tmp_path / "empty").write_text(" \n")
    with pytest.raises(VehicleError, match="empty is empty; write 64 hexadecimal digits"):
        read_key(tmp_path / "empty")
    for content in (KEY, b"key\0", "a passphrase".encode("utf-16")):
        (tmp_path / "binary").write_bytes(content)
        with pytest.raises(VehicleError, match="binary is not text; write its bytes as 64 hexadecimal"):
            read_key(tmp_path / "binary")


def test_a_byte_order_mark_is_no_part_of_a_key(tmp_path: Path) -> None:
    """As some editors write it ahead of any text."""
    (tmp_path / "key").write_text("a passphrase\r\n", encoding="utf-8-sig")
    assert read_key(tmp_path / "key") == KEY


def test_a_key_that_others_can_read_is_noticed(tmp_path: Path) -> None:
    """Mode 600 is private, 640 is not."""
    path = tmp_path / "key"
    path.write_text("a passphrase")
    path.chmod(0o600)
    assert not is_readable_by_others(path)
    path.chmod(0o640)
    assert is_readable_by_others(path)


@pytest.mark.parametrize("old", [False, True], ids=["MAVLink 2", "MAVLink 1"])
def test_pymavlink_accepts_our_signature(old: bool) -> None:
    """Of our own frames, and of a station's in either version; each is later than the one before."""
    vehicle, ours = signer(), signing()
    frame = BEAT.pack(dialect.MAVLink(None, 255, 190), force_mavlink1=old)
    for _ in range(3):
        assert parsed(vehicle, ours.sign(frame)) == ["HEARTBEAT"]
    assert vehicle.signing.goodsig_count == 3


def test_a_signed_frame_is_signed_anew() -> None:
    """A station with another key of its own reaches the vehicle with ours."""
    frame = BEAT.pack(signer(b"\1" * 32))
    assert parsed(signer(), signing().sign(frame)) == ["HEARTBEAT"]


def test_pymavlinks_signature_is_accepted_once() -> None:
    """A frame that comes again, from whatever address, is not heeded."""
    ours, vehicle = signing(), signer()
    frame = BEAT.pack(vehicle)
    assert ours.accepts(frame)
    assert not ours.accepts(frame)
    assert ours.accepts(BEAT.pack(vehicle))


def test_without_the_key_nothing_is_accepted() -> None:
    """Not signed, signed with another key, changed, or of the past."""
    ours = signing()
    changed = bytearray(BEAT.pack(signer()))
    changed[10] ^= 1
    for frame in (
        BEAT.pack(dialect.MAVLink(None, 1, 1)),
        BEAT.pack(dialect.MAVLink(None, 1, 1), force_mavlink1=True),
        BEAT.pack(signer(b"\0" * 32)),
        BEAT.pack(signer(timestamp=NOW - 61 * 100_000)),
        bytes(changed),
    ):
        assert not ours.accepts(frame)
    assert ours.accepts(BEAT.pack(signer(timestamp=NOW - 59 * 100_000)))


def test_a_forged_time_does_not_silence_the_vehicle() -> None:
    """pymavlink's own check would take no frame of the vehicle any more."""
    ours = signing()
    assert not ours.accepts(BEAT.pack(signer(b"\0" * 32, timestamp=(1 << 48) - 2)))
    assert ours.accepts(BEAT.pack(signer()))


def test_our_time_follows_the_vehicles() -> None:
    """A simulator's clock may be ahead; it takes only what is later than all it heard from us before."""
    ours, vehicle = signing(), signer(timestamp=NOW + 10**9)
    assert ours.accepts(BEAT.pack(vehicle))
    stamp = int.from_bytes(ours.sign(BEAT.pack(dialect.MAVLink(None, 255, 25)))[-12:-6], "little")
    assert stamp > NOW + 10**9


@pytest.mark.parametrize("old", [False, True], ids=["MAVLink 2", "MAVLink 1"])
def test_a_radio_needs_no_key(old: bool) -> None:
    """It reports its signal by itself."""
    status = dialect.MAVLink_radio_status_message(1, 2, 3, 4, 5, 6, 7)
    assert signing().accepts(status.pack(dialect.MAVLink(None, 51, 68), force_mavlink1=old))


def test_a_frame_without_its_signature_is_the_message() -> None:
    """For stations that have no key; the checksum is right again."""
    frame = without_signature(BEAT.pack(signer()))
    assert not is_signed(frame)
    assert parsed(dialect.MAVLink(None), frame) == ["HEARTBEAT"]
    assert without_signature(frame) == frame


@pytest.fixture
def vehicle() -> Iterator[Vehicle]:
    vehicle = Vehicle()
    vehicle.mav = signer()
    vehicle.parser = signer(system=255)
    yield vehicle
    vehicle.end()


def test_a_signed_link_signs_and_checks(vehicle: Vehicle, tmp_path: Path) -> None:
    """What is not signed is neither delivered nor recorded; what is recorded is as it was on the link."""
    vehicle.mav.signing.timestamp = vehicle.parser.signing.timestamp = 0
    path = tmp_path / "recorded.tlog"
    with Recorder(path) as recorder:
        link = vehicle.linked(recorder=recorder, signing=Signing(KEY, clock_s=lambda: 0.0))
        received = heard_on(link)
        assert vehicle.heard(1)[0].get_signed()
        forged = dialect.MAVLink_statustext_message(0, b"forged")
        assert vehicle.client
        vehicle.client.sendall(forged.pack(dialect.MAVLink(None, 1, 1)))
        vehicle.send(BEAT)
        message = received.get(timeout=60)
        assert message.get_type() == "HEARTBEAT"
        assert not is_signed(bytes(message.get_msgbuf()))
        assert link.ignored == 1
        station = dialect.MAVLink(None, 255, 190)
        link.forward(forged.pack(station, force_mavlink1=True))
        link.forward(b"\xfd\x00\x00\x00\x00\xff\xbe\xff\xff\xff\x00\x00")  # No message that is known.
        while (heard := vehicle.heard(1)[0]).get_type() == "HEARTBEAT":
            pass
        assert (heard.get_type(), heard.get_srcComponent(), heard.get_signed()) == ("STATUSTEXT", 190, True)
        link.close()
    log = mavutil.mavlink_connection(str(path))
    kept = list(iter(log.recv_msg, None))
    log.close()
    assert {message.get_type() for message in kept} == {"HEARTBEAT", "STATUSTEXT"}
    assert all(is_signed(bytes(message.get_msgbuf())) for message in kept)


def test_a_link_without_a_key_notices_signatures(vehicle: Vehicle) -> None:
    """So that a person is told which option is missing."""
    link = vehicle.linked()
    received = heard_on(link)
    vehicle.send(BEAT)
    assert is_signed(bytes(received.get(timeout=60).get_msgbuf()))
    assert link.received_signed

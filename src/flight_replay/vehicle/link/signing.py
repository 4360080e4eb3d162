"""MAVLink 2 signing (https://mavlink.io/en/guide/message_signing.html): who has no key is not obeyed.

pymavlink signs too, but it remembers the time of a frame before it checks the signature, and for each
parser alone: one forged frame would silence the vehicle, and an old frame from another address would count.
"""

from __future__ import annotations

import hashlib
import hmac
import struct
import threading
import time
from codecs import BOM_UTF8
from collections.abc import Callable
from pathlib import Path

from flight_replay.exceptions import VehicleError
from flight_replay.mavlink import dialect

_KEY_LENGTH = 32
_MAX_FILE_LENGTH = 4096
_OTHERS = 0o077
_LINK_ID = 116  # Any: stations with the same system and component id should have different ones.
_EPOCH_S = 1_420_070_400  # 2015-01-01, from which signatures count ...
_UNITS_PER_S = 100_000  # ... in units of 10 microseconds ...
_MAX_TIME = (1 << 48) - 1  # ... in 48 bits.
_MAX_AGE = 60 * _UNITS_PER_S  # How far a sender that was not heard before may be behind.
_SIGNATURE_LENGTH = 6
_UNSIGNED_MESSAGES = (dialect.MAVLINK_MSG_ID_RADIO_STATUS, dialect.MAVLINK_MSG_ID_RADIO)
"""Radios send these themselves, and have no key."""


def read_key(path: Path) -> bytes:
    """The key in a file: 64 hexadecimal digits, or a passphrase that is hashed as Mission Planner does.

    Raises:
        VehicleError: The file cannot be read, is empty or no text.
    """
    try:
        with path.expanduser().open("rb") as file:
            lines = file.read(_MAX_FILE_LENGTH).removeprefix(BOM_UTF8).splitlines()
    except OSError as error:
        raise VehicleError(
            f"cannot read the signing key {path}: {error.strerror}; give a file with the vehicle's key"
        ) from error
    line = lines[0].strip() if lines else b""
    if not line:
        raise VehicleError(f"the signing key {path} is empty; write 64 hexadecimal digits or a passphrase")
    if not _is_text(line):
        raise VehicleError(f"the signing key {path} is not text; write its bytes as 64 hexadecimal digits")
    try:
        key = bytes.fromhex(line.decode("ascii"))
    except ValueError:
        key = b""
    return key if len(key) == _KEY_LENGTH else hashlib.sha256(line).digest()


def _is_text(line: bytes) -> bool:
    """Whether it can be typed, and is no key in binary, which would be taken for a passphrase."""
    try:
        return line.decode().isprintable()
    except UnicodeDecodeError:
        return False


def is_readable_by_others(path: Path) -> bool:
    """Whether users other than the owner may read a regular file."""
    file = path.expanduser()
    return file.is_file() and bool(file.stat().st_mode & _OTHERS)


def is_signed(frame: bytes) -> bool:
    """Whether a frame has a signature, right or wrong."""
    return frame[0] == dialect.PROTOCOL_MARKER_V2 and bool(frame[2] & dialect.MAVLINK_IFLAG_SIGNED)


def without_signature(frame: bytes) -> bytes:
    """The same message for stations that have no key; a frame without a signature stays as it is."""
    return _packed_anew(frame, flags=0) if is_signed(frame) else frame


class Signing:
    """Signs frames with a key, and tells which received frames are signed with it."""

    def __init__(self, key: bytes, *, clock_s: Callable[[], float] = time.time) -> None:
        """``clock_s`` is the time since 1970, which keeps signatures from repeating after a restart."""
        self._key, self._clock_s = key, clock_s
        self._lock = threading.Lock()
        self._time = self._now()
        self._last: dict[tuple[int, int, int], int] = {}

    def _now(self) -> int:
        return max(int((self._clock_s() - _EPOCH_S) * _UNITS_PER_S), 0)

    def sign(self, frame: bytes) -> bytes:
        """A frame as MAVLink 2 with our signature, whatever it had before.

        Raises:
            KeyError: Its message is unknown, so that its checksum cannot be computed.
        """
        with self._lock:
            self._time = min(max(self._time + 1, self._now()), _MAX_TIME)
            stamp = self._time
        signed = _packed_anew(frame, flags=dialect.MAVLINK_IFLAG_SIGNED)
        signed += bytes([_LINK_ID]) + stamp.to_bytes(6, "little")
        return signed + self._signature(signed)

    def _signature(self, signed: bytes) -> bytes:
        return hashlib.sha256(self._key + signed).digest()[:_SIGNATURE_LENGTH]

    def accepts(self, frame: bytes) -> bool:
        """Whether a received frame is signed with the key and new, or comes from a radio."""
        if not is_signed(frame):
            return _message_id(frame) in _UNSIGNED_MESSAGES
        signed, signature = frame[:-_SIGNATURE_LENGTH], frame[-_SIGNATURE_LENGTH:]
        if not hmac.compare_digest(signature, self._signature(signed)):
            return False
        stamp = int.from_bytes(signed[-6:], "little")
        stream = (signed[-7], frame[5], frame[6])
        with self._lock:
            if stamp <= self._last.get(stream, self._time - _MAX_AGE - 1):
                return False
            self._last[stream] = stamp
            self._time = max(self._time, stamp)
        return True


def _message_id(frame: bytes) -> int:
    if frame[0] == dialect.PROTOCOL_MARKER_V2:
        return int.from_bytes(frame[7:10], "little")
    return frame[5]


def _packed_anew(frame: bytes, *, flags: int) -> bytes:
    """A frame as MAVLink 2 with these incompatibility flags, and without a signature."""
    length, number = frame[1], _message_id(frame)
    header, begins = (b"\0" + frame[2:5], 6) if frame[0] == dialect.PROTOCOL_MARKER_V1 else (frame[3:7], 10)
    body = bytes([length, flags]) + header + number.to_bytes(3, "little") + frame[begins : begins + length]
    checksum = dialect.x25crc(body + bytes([dialect.mavlink_map[number].crc_extra])).crc
    return bytes([dialect.PROTOCOL_MARKER_V2]) + body + struct.pack("<H", checksum)

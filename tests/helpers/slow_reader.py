"""The plain reader that the fast one is held against: it walks every byte offset, one at a time."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from pymavlink.dialects.v10 import all as mavlink1
from pymavlink.dialects.v20 import all as mavlink2

Vehicle = tuple[int, int]


@dataclass(frozen=True)
class Record:
    """A frame that the walk came to."""

    offset: int
    version: int
    message: int
    vehicle: Vehicle
    payload: bytes
    length: int


@dataclass(frozen=True)
class Position:
    """A GLOBAL_POSITION_INT record in its own units, and what was known of the vehicle by then."""

    offset: int
    vehicle: Vehicle
    time_ms: int
    lat_e7: int
    lon_e7: int
    amsl_mm: int
    alt_mm: int
    velocity_cm_s: tuple[int, int, int]
    armed: bool | None
    is_3d: bool | None

    @property
    def key(self) -> int:
        """The vehicle's ids as one number."""
        return self.vehicle[0] * 256 + self.vehicle[1]

    @property
    def is_empty(self) -> bool:
        """No position at all."""
        return self.lat_e7 == 0 and self.lon_e7 == 0


def _byte_table() -> list[int]:
    table = []
    for crc in range(256):
        for _ in range(8):
            crc = crc >> 1 ^ (0x8408 if crc & 1 else 0)  # noqa: PLW2901
        table.append(crc)
    return table


_TABLE = _byte_table()
_FACTS = {number: (kind.crc_extra, kind.unpacker.size) for number, kind in mavlink2.mavlink_map.items()}
_BASE_LENGTHS = {number: kind.unpacker.size for number, kind in mavlink1.mavlink_map.items()}


def crc(data: bytes) -> int:
    """CRC-16/MCRF4XX, a byte at a time."""
    value = 0xFFFF
    for byte in data:
        value = value >> 8 ^ _TABLE[(value ^ byte) & 255]
    return value


def walk(data: bytes) -> Iterator[Record]:
    """Every record of a log: a right frame is skipped whole, anything else by one byte."""
    offset = 0
    while offset < len(data):
        record = _record_at(data, offset)
        if record is None:
            offset += 1
        else:
            yield record
            offset += record.length


def _record_at(data: bytes, offset: int) -> Record | None:
    """The right frame that begins here, if one does."""
    if data[offset] == 0xFE and offset + 8 <= len(data):
        length, _, system, component, message = data[offset + 1 : offset + 6]
        if message not in _FACTS or not _BASE_LENGTHS[message] <= length <= _FACTS[message][1]:
            return None
        return _if_right(data, Record(offset, 1, message, (system, component), b"", 8 + length), 6)
    if data[offset] == 0xFD and offset + 12 <= len(data):
        length, flags, _, _, system, component = data[offset + 1 : offset + 7]
        message = int.from_bytes(data[offset + 7 : offset + 10], "little")
        if message not in _FACTS or flags > 1:
            return None
        whole = 12 + length + 13 * flags
        return _if_right(data, Record(offset, 2, message, (system, component), b"", whole), 10)
    return None


def _if_right(data: bytes, record: Record, header: int) -> Record | None:
    """The record with its payload, if all of it is there and its CRC is right."""
    end = record.offset + header + data[record.offset + 1]
    if record.offset + record.length > len(data):
        return None
    checked = data[record.offset + 1 : end] + bytes([_FACTS[record.message][0]])
    if crc(checked) != int.from_bytes(data[end : end + 2], "little"):
        return None
    payload = data[record.offset + header : end].ljust(_FACTS[record.message][1], b"\0")
    return Record(record.offset, record.version, record.message, record.vehicle, payload, record.length)


def positions(data: bytes) -> list[Position]:
    """Every GLOBAL_POSITION_INT record, with the last heartbeat and receiver's word of its vehicle."""
    armed: dict[Vehicle, bool] = {}
    is_3d: dict[Vehicle, bool] = {}
    found = []
    for record in walk(data):
        if record.message == 0 and record.payload[5] != 8:
            armed[record.vehicle] = record.payload[6] & 128 != 0
        if record.message == 24:
            is_3d[record.vehicle] = record.payload[28] >= 3
        if record.message == 33:
            time_ms, lat, lon, amsl, alt, *velocity = struct.unpack("<Iiiiihhh", record.payload[:26])
            north, east, down = velocity
            found.append(
                Position(
                    record.offset,
                    record.vehicle,
                    time_ms,
                    lat,
                    lon,
                    amsl,
                    alt,
                    (north, east, down),
                    armed.get(record.vehicle),
                    is_3d.get(record.vehicle),
                )
            )
    return found

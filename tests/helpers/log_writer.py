"""Writes telemetry logs for tests, byte by byte and without the reader's code."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

from pymavlink.dialects.v20 import all as dialect
from pymavlink.generator.mavcrc import x25crc

HEARTBEAT, GPS_RAW_INT, GLOBAL_POSITION_INT = 0, 24, 33
STATUSTEXT, ENCAPSULATED_DATA, TUNNEL, FILE_TRANSFER = 253, 131, 385, 110
START_US = 1_700_000_000_000_000


def crc_extra(message: int) -> int:
    """What pymavlink says of a message."""
    return int(dialect.mavlink_map[message].crc_extra)


def frame(  # noqa: PLR0917
    message: int, payload: bytes, version: int = 2, system: int = 1, component: int = 1, signed: bool = False
) -> bytes:
    """A frame with a right CRC; MAVLink 2 payloads are trimmed as the protocol demands."""
    if version == 1:
        checked = bytes([len(payload), 7, system, component, message]) + payload
        return b"\xfe" + checked + _crc(checked, message)
    payload = payload.rstrip(b"\0") or payload[:1]
    checked = bytes([len(payload), signed, 0, 7, system, component]) + message.to_bytes(3, "little") + payload
    return b"\xfd" + checked + _crc(checked, message) + (b"\x01SIGNATURE123"[:13] if signed else b"")


def _crc(checked: bytes, message: int) -> bytes:
    return struct.pack("<H", x25crc(list(checked + bytes([crc_extra(message)]))).crc)


def position_payload(  # noqa: PLR0917
    time_ms: int,
    lat_deg: float = 47.4,
    lon_deg: float = 8.5,
    alt_m: float = 10.0,
    velocity_m_s: tuple[float, float, float] = (0.0, 0.0, 0.0),
    heading_deg: float = 90.0,
) -> bytes:
    """GLOBAL_POSITION_INT, 400 m above sea level at home."""
    whole = [round(value * 1e7) for value in (lat_deg, lon_deg)]
    heights = [round((alt_m + 400) * 1000), round(alt_m * 1000)]
    north, east, up = (round(value * 100) for value in velocity_m_s)
    return struct.pack("<IiiiihhhH", time_ms, *whole, *heights, north, east, -up, round(heading_deg * 100))


def heartbeat_payload(armed: bool = False, vehicle_type: int = 2, autopilot: int = 3) -> bytes:
    """HEARTBEAT of a copter under ArduPilot, unless told otherwise."""
    return struct.pack("<IBBBBB", 0, vehicle_type, autopilot, 0x81 if armed else 0x01, 4, 3)


def gps_payload(fix_type: int, version: int = 2) -> bytes:
    """GPS_RAW_INT with a fix type; what MAVLink 2 added is left out for MAVLink 1."""
    base = struct.pack("<QiiiHHHHBB", 0, 1, 2, 3, 4, 5, 6, 7, fix_type, 9)
    return base if version == 1 else base + struct.pack("<iIIIIH", 1, 2, 3, 4, 5, 6)


@dataclass
class LogWriter:
    """A log in the making: each record gets the stamp ``stamp_us``, unless that is None."""

    version: int = 2
    system: int = 1
    component: int = 1
    stamp_us: int | None = START_US
    data: bytearray = field(default_factory=bytearray)

    def add(self, message: int, payload: bytes, **other: int) -> LogWriter:
        """Append a record of the writer's vehicle, or of another ``system`` or ``component``."""
        ids = {"version": self.version, "system": self.system, "component": self.component, **other}
        if self.stamp_us is not None:
            self.data += struct.pack(">Q", self.stamp_us)
        self.data += frame(message, payload, ids["version"], ids["system"], ids["component"])
        return self

    def position(
        self, time_ms: int, *place: float, velocity: tuple[float, float, float] = (0, 0, 0)
    ) -> LogWriter:
        """Append a position: latitude and longitude in degrees, metres above home."""
        lat_deg, lon_deg, alt_m = (*place, *(47.4, 8.5, 10.0)[len(place) :])
        return self.add(GLOBAL_POSITION_INT, position_payload(time_ms, lat_deg, lon_deg, alt_m, velocity))

    def empty(self, time_ms: int) -> LogWriter:
        """Append a position record without a position."""
        return self.position(time_ms, 0.0, 0.0, 0.0)

    def heartbeat(
        self, armed: bool = False, vehicle_type: int = 2, autopilot: int = 3, **ids: int
    ) -> LogWriter:
        """Append a heartbeat."""
        return self.add(HEARTBEAT, heartbeat_payload(armed, vehicle_type, autopilot), **ids)

    def gps(self, fix_type: int) -> LogWriter:
        """Append what the receiver says of its fix."""
        return self.add(GPS_RAW_INT, gps_payload(fix_type, self.version))

"""Writes small ULogs, by the description of the format in PX4's documents."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence

_CODES = {
    "uint64_t": "Q",
    "uint8_t": "B",
    "bool": "?",
    "float": "f",
    "double": "d",
    "int32_t": "i",
    "int64_t": "q",
}
SYNC = b"\x2f\x73\x13\x20\x25\x0c\xbb\x12"


class UlogWriter:
    """A ULog; ``data`` are its bytes so far. Topics are added before their samples."""

    def __init__(
        self, formats: Mapping[str, Sequence[str]], info: Mapping[str, str | int] | None = None
    ) -> None:
        """Begin a log.

        Args:
            formats: The fields of each topic, as "float x"; a time stamp comes before them.
            info: What the log says of itself.
        """
        self.data = bytearray(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000))
        self._formats = {name: ("uint64_t timestamp", *fields) for name, fields in formats.items()}
        self.message("B", bytes(40))
        for key, value in (info or {}).items():
            text = value.encode() if isinstance(value, str) else struct.pack("<I", value)
            kind = f"char[{len(text)}]" if isinstance(value, str) else "uint32_t"
            title = f"{kind} {key}".encode()
            self.message("I", bytes([len(title)]) + title + text)
        for name, fields in self._formats.items():
            self.message("F", f"{name}:{';'.join(fields)};".encode())
        for number, name in enumerate(self._formats):
            self.message("A", struct.pack("<BH", 0, number) + name.encode())

    def message(self, kind: str, content: bytes) -> UlogWriter:
        """Add a message of any kind."""
        self.data += struct.pack("<HB", len(content), ord(kind)) + content
        return self

    def sample(self, topic: str, time_s: float, *values: float) -> UlogWriter:
        """Add a sample of a topic."""
        kinds = [field.split()[0] for field in self._formats[topic]]
        number = list(self._formats).index(topic)
        row = [round(time_s * 1e6), *values]
        packed = b"".join(
            struct.pack("<" + _CODES[kind], value if kind in ("float", "double") else int(value))
            for kind, value in zip(kinds, row, strict=True)
        )
        return self.message("D", struct.pack("<H", number) + packed)

    def sync(self) -> UlogWriter:
        """Add a mark that readers go on at behind damage."""
        return self.message("S", SYNC)


GLOBAL = {"vehicle_global_position": ("double lat", "double lon", "float alt")}
LOCAL = {
    "vehicle_local_position": (
        "double ref_lat",
        "double ref_lon",
        "float ref_alt",
        "float x",
        "float y",
        "float z",
        "float vx",
        "float vy",
        "float vz",
        "float heading",
        "bool xy_global",
        "bool z_global",
    )
}
STATUS = {"vehicle_status": ("uint8_t arming_state", "uint8_t system_type")}
HOME = {"home_position": ("double lat", "double lon", "float alt", "bool valid_alt")}
LANDED = {"vehicle_land_detected": ("bool landed",)}
OLD_GPS = {
    "vehicle_gps_position": (
        "int32_t lat",
        "int32_t lon",
        "int32_t alt",
        "uint8_t fix_type",
        "uint64_t time_utc_usec",
    )
}
NEW_GPS = {
    "sensor_gps": ("double latitude_deg", "double longitude_deg", "double altitude_msl_m", "uint8_t fix_type")
}
INFO: dict[str, str | int] = {"sys_name": "PX4", "ver_sw_release": 0x010F04FF}

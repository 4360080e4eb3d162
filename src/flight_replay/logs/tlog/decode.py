"""Valid frames to columns.

Layouts are those of mavlink.io (common.xml, minimal.xml), little endian; MAVLink 2 leaves
zeros off a payload's end, and they are put back here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Bytes
from flight_replay.logs.tlog.columns import FIX_3D, GpsStatus, Heartbeats, Positions
from flight_replay.logs.tlog.frames import STAMP_LENGTH, Candidates
from flight_replay.logs.tlog.message_table import MAVLINK1_STX

_ARMED_FLAG = 128  # MAV_MODE_FLAG_SAFETY_ARMED
FIX_TYPE_AT, SECOND_FIX_TYPE_AT = 28, 32  # in the payloads of GPS_RAW_INT and GPS2_RAW
_PAYLOAD_AT = STAMP_LENGTH + 6, STAMP_LENGTH + 10  # in a row, for MAVLink 1 and 2


def decode_positions(frames: Candidates) -> Positions:
    """Decode GLOBAL_POSITION_INT: seven columns of four bytes, the last two of two numbers each."""
    fields = PayloadFields(frames.rows)
    payload = fields.payload(28)
    number, half = payload.view("<i4"), payload.view("<i2")
    return Positions(
        offset=frames.start,
        vehicle=fields.vehicle,
        stamp_us=fields.stamp_us,
        time_ms=number[:, 0].view("<u4"),
        lat_e7=number[:, 1],
        lon_e7=number[:, 2],
        amsl_mm=number[:, 3],
        alt_mm=number[:, 4],
        north_cm_s=half[:, 10],
        east_cm_s=half[:, 11],
        down_cm_s=half[:, 12],
        heading_cdeg=half[:, 13].view("<u2"),
    )


def decode_heartbeats(frames: Candidates) -> Heartbeats:
    """Decode HEARTBEAT: behind four bytes of mode, the lowest first, follow type, autopilot and flags."""
    fields = PayloadFields(frames.rows)
    mode, kind, autopilot, flags = (fields.payload_byte(at) for at in (0, 4, 5, 6))
    return Heartbeats(frames.start, fields.vehicle, autopilot, kind, (flags & _ARMED_FLAG) != 0, mode)


def decode_gps_status(frames: Candidates, fix_type_at: int = FIX_TYPE_AT) -> GpsStatus:
    """Decode GPS_RAW_INT, of whose own position nothing is read: cold receivers make them up.

    GPS2_RAW has four bytes more before the type of the fix.
    """
    fields = PayloadFields(frames.rows)
    fix_type = fields.payload_byte(fix_type_at)
    fix = np.where(fix_type >= FIX_3D, np.uint8(FIX_3D), (fix_type > 0).view(np.uint8))
    return GpsStatus(frames.start, fields.vehicle, fix)


class PayloadFields:
    """What the bytes of frames (n,) say; MAVLink 2 has two bytes of flags before its sequence number."""

    def __init__(self, rows: Bytes) -> None:
        self._rows = rows
        self._is_mavlink1 = rows[:, STAMP_LENGTH] == MAVLINK1_STX
        self._sent = rows[:, STAMP_LENGTH + 1]  # bytes of payload
        self._is_all_mavlink1 = bool(self._is_mavlink1.all())

    def _byte(self, mavlink1: int, mavlink2: int) -> NDArray[np.uint8]:
        """The byte at that place in a row of either version, shape (n,)."""
        first, second = self._rows[:, mavlink1], self._rows[:, mavlink2]
        return first if self._is_all_mavlink1 else np.where(self._is_mavlink1, first, second)

    @property
    def vehicle(self) -> NDArray[np.uint16]:
        """System id * 256 + component id, shape (n,)."""
        system = self._byte(STAMP_LENGTH + 3, STAMP_LENGTH + 5)
        component = self._byte(STAMP_LENGTH + 4, STAMP_LENGTH + 6)
        return np.asarray(system.astype(np.uint16) << 8 | component, np.uint16)

    @property
    def stamp_us(self) -> NDArray[np.int64]:
        """The stamps before the frames, shape (n,)."""
        return self._rows[:, :STAMP_LENGTH].view(">i8")[:, 0].astype(np.int64)

    def payload_byte(self, at: int) -> NDArray[np.uint8]:
        """A byte of each payload, 0 where it was left off, shape (n,)."""
        mavlink1, mavlink2 = _PAYLOAD_AT
        return np.asarray(self._byte(mavlink1 + at, mavlink2 + at) * (self._sent > at), np.uint8)

    def payload(self, length: int) -> Bytes:
        """The first bytes of each payload, zeros where they were left off, shape (n, length)."""
        mavlink1, mavlink2 = _PAYLOAD_AT
        first = mavlink1 if self._is_all_mavlink1 else mavlink2
        some: Bytes = self._rows[:, first : first + length].copy()
        if self._is_all_mavlink1:
            return some
        some[self._is_mavlink1] = self._rows[self._is_mavlink1, mavlink1 : mavlink1 + length]
        for short in np.flatnonzero(np.bincount(self._sent)[:length]).tolist():
            some[self._sent == short, short:] = 0
        return some

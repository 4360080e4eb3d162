"""Bytes of frames to columns.

Layouts are those of mavlink.io (common.xml, minimal.xml), little endian; MAVLink 2 leaves
zeros off a payload's end, and they are put back here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Bytes, Indices
from flight_replay.logs.tlog import message_table
from flight_replay.logs.tlog.columns import Positions
from flight_replay.logs.tlog.frame_walk import are_right
from flight_replay.logs.tlog.frames import STAMP_LENGTH, Candidates, Marked

_ARMED_FLAG = 128  # MAV_MODE_FLAG_SAFETY_ARMED
_FIX_TYPE_3D = 3  # GPS_FIX_TYPE_3D_FIX


@dataclass(frozen=True, slots=True, eq=False)
class States:
    """What the candidates of a message tell of their vehicles' states, every column of shape (n,)."""

    message: int
    candidates: Candidates
    vehicle: NDArray[np.uint16]
    state: NDArray[np.int32]

    def take(self, index: Indices) -> States:
        """Those of an index array."""
        candidates = self.candidates.take(index)
        return States(self.message, candidates, self.vehicle.take(index), self.state.take(index))


@dataclass(frozen=True, slots=True, eq=False)
class Decoded:
    """All that marked bytes may say: right positions, ``offset`` being where in the bytes, and states."""

    positions: Positions
    heartbeats: States
    fixes: States


def decode(marked: Marked) -> Decoded:
    """What the candidates of the three messages say."""
    return Decoded(
        _positions(marked.data, marked.wanted[message_table.GLOBAL_POSITION_INT]),
        _heartbeats(marked.wanted[message_table.HEARTBEAT]),
        _fixes(marked.wanted[message_table.GPS_RAW_INT]),
    )


class _Fields:
    """What the bytes of candidates (n,) say; MAVLink 2 has two bytes of flags before its sequence number."""

    def __init__(self, rows: Bytes) -> None:
        self._rows = rows
        self._is_mavlink1 = rows[:, STAMP_LENGTH] == message_table.MAVLINK1_MARK
        self._sent = rows[:, STAMP_LENGTH + 1]  # bytes of payload
        self._is_all_mavlink1 = bool(self._is_mavlink1.all())

    def _byte(self, mavlink1: int, mavlink2: int) -> NDArray[np.uint8]:
        """The byte at that place in a frame of either version, shape (n,)."""
        first, second = self._rows[:, STAMP_LENGTH + mavlink1], self._rows[:, STAMP_LENGTH + mavlink2]
        return first if self._is_all_mavlink1 else np.where(self._is_mavlink1, first, second)

    @property
    def vehicle(self) -> NDArray[np.uint16]:
        """System id * 256 + component id, shape (n,)."""
        system, component = self._byte(3, 5), self._byte(4, 6)
        return np.asarray(system.astype(np.uint16) << 8 | component, np.uint16)

    @property
    def stamp_us(self) -> NDArray[np.int64]:
        """The stamps before the frames, shape (n,)."""
        return self._rows[:, :STAMP_LENGTH].view(">i8")[:, 0].astype(np.int64)

    def payload_byte(self, at: int) -> NDArray[np.int32]:
        """A byte of each payload, 0 where it was left off, shape (n,)."""
        byte = self._byte(6 + at, 10 + at).astype(np.int32)
        byte *= self._sent > at
        return byte

    def payload(self, length: int) -> Bytes:
        """The first bytes of each payload, zeros where they were left off, shape (n, length)."""
        mavlink1, mavlink2 = STAMP_LENGTH + 6, STAMP_LENGTH + 10
        if self._is_all_mavlink1:
            return self._rows[:, mavlink1 : mavlink1 + length]
        some: Bytes = self._rows[:, mavlink2 : mavlink2 + length].copy()
        some[self._is_mavlink1] = self._rows[self._is_mavlink1, mavlink1 : mavlink1 + length]
        for short in np.flatnonzero(np.bincount(self._sent)[:length]).tolist():
            some[self._sent == short, short:] = 0
        return some


def _positions(data: Bytes, candidates: Candidates) -> Positions:
    """Decode GLOBAL_POSITION_INT: seven columns of four bytes, the last two of two numbers each."""
    right = are_right(data, candidates, message_table.GLOBAL_POSITION_INT)
    if not right.all():
        candidates = candidates.take(np.flatnonzero(right))
    fields = _Fields(candidates.rows)
    payload = fields.payload(28)
    number, half = payload.view("<i4"), payload.view("<i2")
    return Positions(
        offset=candidates.start,
        vehicle=fields.vehicle,
        stamp_us=fields.stamp_us,
        time_ms=number[:, 0].view("<u4").copy(),
        lat_e7=number[:, 1].copy(),
        lon_e7=number[:, 2].copy(),
        amsl_mm=number[:, 3].copy(),
        alt_mm=number[:, 4].copy(),
        north_cm_s=half[:, 10].copy(),
        east_cm_s=half[:, 11].copy(),
        down_cm_s=half[:, 12].copy(),
    )


def _heartbeats(candidates: Candidates) -> States:
    """Decode HEARTBEAT: behind four bytes of mode follow type, autopilot and flags."""
    fields = _Fields(candidates.rows)
    kind, autopilot, flags = (fields.payload_byte(at) for at in (4, 5, 6))
    state = kind << 16 | autopilot << 8 | flags & _ARMED_FLAG
    return States(message_table.HEARTBEAT, candidates, fields.vehicle, state)


def _fixes(candidates: Candidates) -> States:
    """Decode GPS_RAW_INT, of whose own position nothing is read: cold receivers make them up."""
    fields = _Fields(candidates.rows)
    is_3d = fields.payload_byte(28) >= _FIX_TYPE_3D
    return States(message_table.GPS_RAW_INT, candidates, fields.vehicle, is_3d.astype(np.int32))

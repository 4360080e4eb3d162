"""Records of the three messages that positions are read from, as columns of equal length.

Layouts are those of mavlink.io (common.xml, minimal.xml), little endian; MAVLink 2 leaves
zeros off a payload's end, and they are put back here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from flight_replay.tlog import messages
from flight_replay.tlog.crc import Bytes, Flags, Index, rows_at
from flight_replay.tlog.frames import Frames

AnyColumns = TypeVar("AnyColumns", bound="Columns")


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """Records in the order of the log, every column of shape (n,).

    ``offset`` is the record's place in the log, ``vehicle`` its system id * 256 + component id.
    """

    offset: NDArray[np.int64]
    vehicle: NDArray[np.uint16]

    def __len__(self) -> int:
        return len(self.offset)

    def select(self: AnyColumns, keep: Flags | Index) -> AnyColumns:
        """The records that a mask or an index array picks."""
        if keep.dtype == np.bool_ and keep.all():
            return self
        return type(self)(**{each.name: getattr(self, each.name)[keep] for each in fields(self)})


@dataclass(frozen=True, slots=True, eq=False)
class Positions(Columns):
    """GLOBAL_POSITION_INT in its own units; ``stamp_us`` is what the eight bytes before the record say."""

    stamp_us: NDArray[np.int64]
    time_ms: NDArray[np.uint32]
    lat_e7: NDArray[np.int32]
    lon_e7: NDArray[np.int32]
    amsl_mm: NDArray[np.int32]
    alt_mm: NDArray[np.int32]
    north_cm_s: NDArray[np.int16]
    east_cm_s: NDArray[np.int16]
    down_cm_s: NDArray[np.int16]

    @property
    def is_empty(self) -> Flags:
        """Where latitude and longitude are both 0: no position at all."""
        return np.asarray((self.lat_e7 == 0) & (self.lon_e7 == 0))


@dataclass(frozen=True, slots=True, eq=False)
class Heartbeats(Columns):
    """HEARTBEAT: who sent it (MAV_AUTOPILOT, MAV_TYPE), and whether the motors were armed."""

    autopilot: NDArray[np.uint8]
    type: NDArray[np.uint8]
    armed: Flags


@dataclass(frozen=True, slots=True, eq=False)
class Fixes(Columns):
    """GPS_RAW_INT: whether the receiver had a 3D fix or better."""

    is_3d: Flags


@dataclass(frozen=True, slots=True, eq=False)
class Records:
    """What was read; ``empty`` counts the positions at 0, 0 by vehicle."""

    positions: Positions
    heartbeats: Heartbeats
    fixes: Fixes
    empty: dict[int, int]


_STAMP_LENGTH = 8
_ARMED_FLAG = 128  # MAV_MODE_FLAG_SAFETY_ARMED
_FIX_TYPE_3D = 3  # GPS_FIX_TYPE_3D_FIX


def decode(data: Bytes, offset: int, frames: Frames) -> Records:
    """Columns of checked frames in bytes that begin ``offset`` bytes into the log.

    Of what says nothing new, only the ends of each run are kept, so that memory stays constant
    for logs that hold no position but many of the other records.
    """
    positions, empty = _positions(data, offset, _of_message(data, frames, messages.GLOBAL_POSITION_INT))
    heartbeats = _heartbeats(data, offset, _of_message(data, frames, messages.HEARTBEAT))
    fixes = _fixes(data, offset, _of_message(data, frames, messages.GPS_RAW_INT))
    state = (heartbeats.autopilot.astype(np.int32) << 8 | heartbeats.type) << 1 | heartbeats.armed
    return Records(
        positions,
        heartbeats.select(_run_ends(heartbeats.vehicle, state)),
        fixes.select(_run_ends(fixes.vehicle, fixes.is_3d)),
        empty,
    )


def joined(parts: Sequence[Records]) -> Records:
    """Records of consecutive parts of a log as one."""
    empty: dict[int, int] = {}
    for part in parts:
        for vehicle, count in part.empty.items():
            empty[vehicle] = empty.get(vehicle, 0) + count
    return Records(
        _concatenated([part.positions for part in parts]),
        _concatenated([part.heartbeats for part in parts]),
        _concatenated([part.fixes for part in parts]),
        empty,
    )


def _concatenated(parts: list[AnyColumns]) -> AnyColumns:
    names = [each.name for each in fields(parts[0])]
    return type(parts[0])(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in names})


@dataclass(frozen=True, slots=True, eq=False)
class _Payloads:
    """Where frames of one message have their start, payload and ids, and their payloads' length; all (n,)."""

    start: Index
    payload: Index
    length: NDArray[np.uint8]
    vehicle: NDArray[np.uint16]

    def select(self, keep: Index) -> _Payloads:
        """The frames that an index array picks."""
        return _Payloads(self.start[keep], self.payload[keep], self.length[keep], self.vehicle[keep])

    def byte(self, data: Bytes, at: int) -> NDArray[np.uint8]:
        """One byte of each payload, zero where it was left off, shape (n,)."""
        values = data.take(self.payload + at)
        values[self.length <= at] = 0
        return values

    def rows(self, data: Bytes, length: int) -> Bytes:
        """The first ``length`` bytes of each payload, zeros where they were left off, shape (n, length)."""
        rows = rows_at(data, self.payload, length)
        for short in np.flatnonzero(np.bincount(self.length)[:length]):
            rows[self.length == short, short:] = 0
        return rows


def _of_message(data: Bytes, frames: Frames, message: int) -> _Payloads:
    """The frames of one message. Behind the start mark, MAVLink 2 has two bytes of flags more than 1."""
    own = np.flatnonzero(frames.message == message)
    start, is_mavlink1 = frames.start.take(own), frames.is_mavlink1.take(own)
    ids = start + np.where(is_mavlink1, 3, 5)
    return _Payloads(
        start=start,
        payload=start + np.where(is_mavlink1, 6, 10),
        length=data[1:].take(start),
        vehicle=rows_at(data, ids, 2).view(">u2")[:, 0].astype(np.uint16),
    )


def _positions(data: Bytes, offset: int, payloads: _Payloads) -> tuple[Positions, dict[int, int]]:
    """Decode GLOBAL_POSITION_INT: seven columns of four bytes, the last two of two numbers each.

    Also counts the empty positions by vehicle, and leaves out what runs of them have between their ends.
    """
    rows = payloads.rows(data, 28)
    number, half = rows.view("<i4"), rows.view("<i2")
    is_empty = (number[:, 1] | number[:, 2]) == 0
    empty: dict[int, int] = {}
    if is_empty.any():
        vehicles, counts = np.unique(payloads.vehicle[is_empty], return_counts=True)
        empty = dict(zip(vehicles.tolist(), counts.tolist(), strict=True))
        told = _run_ends(payloads.vehicle, np.where(is_empty, _falls(number[:, 0].view("<u4")), -1))
        kept = np.flatnonzero(told | ~is_empty)
        payloads = payloads.select(kept)
        rows = payloads.rows(data, 28)
        number, half = rows.view("<i4"), rows.view("<i2")
    stamps = rows_at(data, payloads.start - _STAMP_LENGTH, _STAMP_LENGTH)
    positions = Positions(
        offset=payloads.start + offset,
        vehicle=payloads.vehicle,
        stamp_us=stamps.view(">i8")[:, 0].astype(np.int64),
        time_ms=number[:, 0].view("<u4").copy(),
        lat_e7=number[:, 1].copy(),
        lon_e7=number[:, 2].copy(),
        amsl_mm=number[:, 3].copy(),
        alt_mm=number[:, 4].copy(),
        north_cm_s=half[:, 10].copy(),
        east_cm_s=half[:, 11].copy(),
        down_cm_s=half[:, 12].copy(),
    )
    return positions, empty


def _heartbeats(data: Bytes, offset: int, payloads: _Payloads) -> Heartbeats:
    """Decode HEARTBEAT, whose first four bytes are the mode."""
    return Heartbeats(
        offset=payloads.start + offset,
        vehicle=payloads.vehicle,
        type=payloads.byte(data, 4),
        autopilot=payloads.byte(data, 5),
        armed=payloads.byte(data, 6) & _ARMED_FLAG != 0,
    )


def _fixes(data: Bytes, offset: int, payloads: _Payloads) -> Fixes:
    """Decode GPS_RAW_INT, of whose own position nothing is read: cold receivers make them up."""
    return Fixes(
        offset=payloads.start + offset,
        vehicle=payloads.vehicle,
        is_3d=payloads.byte(data, 28) >= _FIX_TYPE_3D,
    )


def _falls(time_ms: NDArray[np.uint32]) -> Index:
    """How often a clock has fallen so far, shape (n,)."""
    return np.cumsum(time_ms < np.concatenate([time_ms[:1], time_ms[:-1]]))


def _run_ends(vehicle: NDArray[np.uint16], value: NDArray[Any]) -> Flags:
    """Where a vehicle's value begins or ends a run of equal ones, shape (n,)."""
    order = np.arange(len(vehicle))
    if (vehicle[1:] != vehicle[:-1]).any():
        order = np.argsort(vehicle, kind="stable")
        vehicle, value = vehicle[order], value[order]
    same = (vehicle[1:] == vehicle[:-1]) & (value[1:] == value[:-1])
    ends = np.ones(len(vehicle), np.bool_)
    ends[order[1:-1]] = ~(same[1:] & same[:-1])
    return ends

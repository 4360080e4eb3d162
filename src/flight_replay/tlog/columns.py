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
from flight_replay.tlog.frames import Marked, Walk

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


def decode(walk: Walk, base: int) -> Records:
    """Columns of the records that a walk finds in bytes which begin ``base`` bytes into the log.

    Of what says nothing new, only the ends of each run are kept, so that memory stays constant
    for logs that hold no position but many of the other records.
    """
    positions, empty = _positions(walk, base)
    return Records(positions, _heartbeats(walk, base), _fixes(walk, base), empty)


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


class _Frames:
    """Some frames of a marked span, by their index (n,): where they are, and what their bytes say.

    Behind the start mark, MAVLink 2 has two bytes of flags more than MAVLink 1.
    """

    def __init__(self, marked: Marked, index: Index) -> None:
        self._data = marked.data
        self.start = marked.start.take(index)
        self._is_mavlink1 = marked.is_mavlink1.take(index)

    @property
    def vehicle(self) -> NDArray[np.uint16]:
        """System id * 256 + component id, shape (n,)."""
        ids = self.start + np.where(self._is_mavlink1, 3, 5)
        return rows_at(self._data, ids, 2).view(">u2")[:, 0].astype(np.uint16)

    @property
    def stamp_us(self) -> NDArray[np.int64]:
        """The stamps before the frames, shape (n,)."""
        stamps = rows_at(self._data, self.start - _STAMP_LENGTH, _STAMP_LENGTH)
        return stamps.view(">i8")[:, 0].astype(np.int64)

    def payload(self, first: int, behind: int) -> Bytes:
        """Some bytes of each payload, zeros where they were left off, shape (n, behind - first)."""
        places = self.start + np.where(self._is_mavlink1, 6 + first, 10 + first)
        rows = rows_at(self._data, places, behind - first)
        length = self._data[1:].take(self.start)
        for short in np.flatnonzero(np.bincount(length)[:behind]).tolist():
            rows[length == short, max(short - first, 0) :] = 0
        return rows


def _positions(walk: Walk, base: int) -> tuple[Positions, dict[int, int]]:
    """Decode GLOBAL_POSITION_INT: seven columns of four bytes, the last two of two numbers each.

    Also counts the empty positions by vehicle, and leaves out what runs of them have between their ends.
    """
    index = walk.candidates(messages.GLOBAL_POSITION_INT)
    index, empty = _without_empty_runs(walk.marked, index[walk.finds(index)])
    frames = _Frames(walk.marked, index)
    rows = frames.payload(0, 28)
    number, half = rows.view("<i4"), rows.view("<i2")
    positions = Positions(
        offset=frames.start + base,
        vehicle=frames.vehicle,
        stamp_us=frames.stamp_us,
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


def _without_empty_runs(marked: Marked, index: Index) -> tuple[Index, dict[int, int]]:
    """Positions but for the inner ones of runs of empty ones, and the number of empty ones by vehicle."""
    frames = _Frames(marked, index)
    numbers = frames.payload(0, 12).view("<u4")
    is_empty = (numbers[:, 1] | numbers[:, 2]) == 0
    if not is_empty.any():
        return index, {}
    vehicle = frames.vehicle
    vehicles, counts = np.unique(vehicle[is_empty], return_counts=True)
    told = _run_ends(vehicle, np.where(is_empty, _falls(numbers[:, 0]), -1))
    return index[told | ~is_empty], dict(zip(vehicles.tolist(), counts.tolist(), strict=True))


def _heartbeats(walk: Walk, base: int) -> Heartbeats:
    """Decode HEARTBEAT: behind four bytes of mode follow type, autopilot and flags."""
    index = walk.candidates(messages.HEARTBEAT)
    frames = _Frames(walk.marked, index)
    vehicle, rows = frames.vehicle, frames.payload(4, 7)
    rows[:, 2] &= _ARMED_FLAG
    state = rows[:, 0].astype(np.int32) << 16 | rows[:, 1].astype(np.int32) << 8 | rows[:, 2]
    kept = _checked_run_ends(walk, index, vehicle, state)
    rows = rows[kept]
    return Heartbeats(frames.start[kept] + base, vehicle[kept], rows[:, 1], rows[:, 0], rows[:, 2] != 0)


def _fixes(walk: Walk, base: int) -> Fixes:
    """Decode GPS_RAW_INT, of whose own position nothing is read: cold receivers make them up."""
    index = walk.candidates(messages.GPS_RAW_INT)
    frames = _Frames(walk.marked, index)
    vehicle, is_3d = frames.vehicle, frames.payload(28, 29)[:, 0] >= _FIX_TYPE_3D
    kept = _checked_run_ends(walk, index, vehicle, is_3d)
    return Fixes(frames.start[kept] + base, vehicle[kept], is_3d[kept])


def _checked_run_ends(walk: Walk, index: Index, vehicle: NDArray[np.uint16], state: NDArray[Any]) -> Index:
    """The records at which a vehicle's state begins or ends to be told.

    Only these are checked, and where one is no record, all that tell the same: whether other
    frames within a run are records makes no difference.
    """
    checked = np.zeros(len(index), np.bool_)
    is_left = np.ones(len(index), np.bool_)
    said = vehicle.astype(np.int64) << 32 | state
    while True:
        left = np.flatnonzero(is_left)
        ends = left[_run_ends(vehicle[left], state[left])]
        fresh = ends[~checked[ends]]
        right = walk.finds(index[fresh])
        if right.all():
            return ends
        is_left[fresh] = right
        checked[fresh] = True
        unsaid = np.sort(said[fresh[~right]])
        alike = unsaid.take(np.searchsorted(unsaid, said), mode="clip") == said
        alike = np.flatnonzero(alike & ~checked)
        is_left[alike] = walk.finds(index[alike])
        checked[alike] = True


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

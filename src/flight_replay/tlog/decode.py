"""Bytes of checked frames to columns.

Layouts are those of mavlink.io (common.xml, minimal.xml), little endian; MAVLink 2 leaves
zeros off a payload's end, and they are put back here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flight_replay.tlog import messages
from flight_replay.tlog.columns import Fixes, Heartbeats, Positions, Records
from flight_replay.tlog.crc import Bytes, Flags, Index, rows_at
from flight_replay.tlog.frames import Frames, Walk

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


class _Decoder:
    """What the bytes of frames (n,) say; MAVLink 2 has two bytes of flags before its sequence number."""

    def __init__(self, data: Bytes, frames: Frames) -> None:
        self._data = data
        self.start = frames.start
        self._is_mavlink1 = frames.is_mavlink1

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
    frames = walk.candidates(messages.GLOBAL_POSITION_INT)
    frames = frames.take(np.flatnonzero(walk.finds(frames, messages.GLOBAL_POSITION_INT)))
    frames, empty = _without_empty_runs(walk.data, frames)
    decoder = _Decoder(walk.data, frames)
    rows = decoder.payload(0, 28)
    number, half = rows.view("<i4"), rows.view("<i2")
    positions = Positions(
        offset=frames.start + base,
        vehicle=decoder.vehicle,
        stamp_us=decoder.stamp_us,
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


def _without_empty_runs(data: Bytes, frames: Frames) -> tuple[Frames, dict[int, int]]:
    """Positions but for the inner ones of runs of empty ones, and the number of empty ones by vehicle."""
    decoder = _Decoder(data, frames)
    numbers = decoder.payload(0, 12).view("<u4")
    is_empty = (numbers[:, 1] | numbers[:, 2]) == 0
    if not is_empty.any():
        return frames, {}
    vehicle = decoder.vehicle
    counts = np.bincount(vehicle[is_empty])
    told = _run_ends(vehicle, np.where(is_empty, _falls(numbers[:, 0]), -1))
    kept = frames.take(np.flatnonzero(told | ~is_empty))
    return kept, {key: int(counts[key]) for key in np.flatnonzero(counts).tolist()}


def _heartbeats(walk: Walk, base: int) -> Heartbeats:
    """Decode HEARTBEAT: behind four bytes of mode follow type, autopilot and flags."""
    frames = walk.candidates(messages.HEARTBEAT)
    decoder = _Decoder(walk.data, frames)
    vehicle, rows = decoder.vehicle, decoder.payload(4, 7)
    rows[:, 2] &= _ARMED_FLAG
    state = rows[:, 0].astype(np.int32) << 16 | rows[:, 1].astype(np.int32) << 8 | rows[:, 2]
    kept = _checked_run_ends(lambda some: walk.finds(frames.take(some), messages.HEARTBEAT), vehicle, state)
    rows = rows[kept]
    return Heartbeats(frames.start[kept] + base, vehicle[kept], rows[:, 1], rows[:, 0], rows[:, 2] != 0)


def _fixes(walk: Walk, base: int) -> Fixes:
    """Decode GPS_RAW_INT, of whose own position nothing is read: cold receivers make them up."""
    frames = walk.candidates(messages.GPS_RAW_INT)
    decoder = _Decoder(walk.data, frames)
    vehicle, is_3d = decoder.vehicle, decoder.payload(28, 29)[:, 0] >= _FIX_TYPE_3D
    kept = _checked_run_ends(lambda some: walk.finds(frames.take(some), messages.GPS_RAW_INT), vehicle, is_3d)
    return Fixes(frames.start[kept] + base, vehicle[kept], is_3d[kept])


def _checked_run_ends(
    are_records: Callable[[Index], Flags], vehicle: NDArray[np.uint16], state: NDArray[Any]
) -> Index:
    """The records at which a vehicle's state begins or ends to be told, as indices of candidates (n,).

    Only these are checked, and where one is no record, all that tell the same: whether other
    frames within a run are records makes no difference.
    """
    checked = np.zeros(len(vehicle), np.bool_)
    is_left = np.ones(len(vehicle), np.bool_)
    said = vehicle.astype(np.int64) << 32 | state
    while True:
        left = np.flatnonzero(is_left)
        ends = left[_run_ends(vehicle[left], state[left])]
        fresh = ends[~checked[ends]]
        right = are_records(fresh)
        if right.all():
            return ends
        is_left[fresh] = right
        checked[fresh] = True
        unsaid = np.sort(said[fresh[~right]])
        alike = unsaid.take(np.searchsorted(unsaid, said), mode="clip") == said
        alike = np.flatnonzero(alike & ~checked)
        is_left[alike] = are_records(alike)
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

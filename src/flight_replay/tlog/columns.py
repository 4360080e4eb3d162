"""Records of the three messages that positions are read from, as tables: one row a record.

Layouts are those of mavlink.io (common.xml, minimal.xml), little endian; MAVLink 2 leaves
zeros off a payload's end, and they are put back here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike, NDArray

from flight_replay.tlog import messages
from flight_replay.tlog.crc import Bytes
from flight_replay.tlog.frames import Group

Table = NDArray[np.void]

_POSITION = [
    ("time_ms", "<u4"),
    ("lat_e7", "<i4"),
    ("lon_e7", "<i4"),
    ("amsl_mm", "<i4"),
    ("alt_mm", "<i4"),
    ("north_cm_s", "<i2"),
    ("east_cm_s", "<i2"),
    ("down_cm_s", "<i2"),
]
_POSITION_LENGTH = 26  # without the heading, which nothing here needs
_WHERE = [("offset", "<i8"), ("vehicle", "<u2")]
POSITIONS = np.dtype([*_WHERE, ("stamp_us", "<i8"), *_POSITION])
"""GLOBAL_POSITION_INT: ``stamp_us`` is what the eight bytes before the record say, whatever they are."""
HEARTBEATS = np.dtype([*_WHERE, ("autopilot", "u1"), ("type", "u1"), ("armed", "?")])
FIXES = np.dtype([*_WHERE, ("is_3d", "?")])
"""GPS_RAW_INT: whether the receiver had a 3D fix or better."""

_STAMP_LENGTH = 8
_ARMED_FLAG = 128  # MAV_MODE_FLAG_SAFETY_ARMED
_FIX_TYPE_3D = 3  # GPS_FIX_TYPE_3D_FIX


@dataclass(frozen=True, slots=True)
class Records:
    """What was read, in the order of the log; ``empty`` counts positions at 0, 0 by vehicle."""

    positions: Table
    heartbeats: Table
    fixes: Table
    empty: dict[int, int]


def decode(block: Bytes, offset: int, groups: Sequence[Group]) -> Records:
    """Tables of checked frames in a block that begins ``offset`` bytes into the log."""
    positions = _table(POSITIONS, groups, messages.GLOBAL_POSITION_INT, block, offset)
    heartbeats = _table(HEARTBEATS, groups, messages.HEARTBEAT, block, offset)
    fixes = _table(FIXES, groups, messages.GPS_RAW_INT, block, offset)
    is_empty = (positions["lat_e7"] == 0) & (positions["lon_e7"] == 0)
    vehicles, counts = np.unique(positions["vehicle"][is_empty], return_counts=True)
    return Records(
        _without_runs(positions, np.where(is_empty, _falls(positions["time_ms"]), -1), is_empty),
        _without_runs(heartbeats, _states(heartbeats)),
        _without_runs(fixes, fixes["is_3d"]),
        dict(zip(vehicles.tolist(), counts.tolist(), strict=True)),
    )


def joined(parts: Sequence[Records]) -> Records:
    """Records of consecutive blocks as one."""
    empty: dict[int, int] = {}
    for part in parts:
        for vehicle, count in part.empty.items():
            empty[vehicle] = empty.get(vehicle, 0) + count
    return Records(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.heartbeats for part in parts]),
        np.concatenate([part.fixes for part in parts]),
        empty,
    )


def _table(
    dtype: np.dtype[np.void], groups: Sequence[Group], message: int, block: Bytes, offset: int
) -> Table:
    """All records of one message, in the order of the block."""
    parts = [np.zeros(0, dtype)]
    for group in groups:
        if group.message == message:
            table = np.empty(len(group.start), dtype)
            table["offset"] = group.start + offset
            table["vehicle"] = group.vehicle
            _FILLERS[message](table, group, block)
            parts.append(table)
    table = np.concatenate(parts)
    return table if len(parts) <= 2 else table[np.argsort(table["offset"])]


def _fill_positions(table: Table, group: Group, block: Bytes) -> None:
    values = _filled_up(group.payload, _POSITION_LENGTH).view(_POSITION)[:, 0]
    for name, _ in _POSITION:
        table[name] = values[name]
    stamps = np.ndarray((len(block) - _STAMP_LENGTH + 1,), f"V{_STAMP_LENGTH}", block, strides=(1,))
    table["stamp_us"] = stamps[group.start - _STAMP_LENGTH].view(">i8")


def _fill_heartbeats(table: Table, group: Group, _: Bytes) -> None:
    payload = _filled_up(group.payload, 9)
    table["type"], table["autopilot"] = payload[:, 4], payload[:, 5]
    table["armed"] = payload[:, 6] & _ARMED_FLAG != 0


def _fill_fixes(table: Table, group: Group, _: Bytes) -> None:
    table["is_3d"] = _filled_up(group.payload, 30)[:, 28] >= _FIX_TYPE_3D


_FILLERS = {
    messages.GLOBAL_POSITION_INT: _fill_positions,
    messages.HEARTBEAT: _fill_heartbeats,
    messages.GPS_RAW_INT: _fill_fixes,
}


def _filled_up(payload: Bytes, length: int) -> Bytes:
    """The first ``length`` bytes of payloads, zeros where a trimmed one ends, shape (n, length)."""
    filled = np.zeros((len(payload), length), np.uint8)
    sent = min(payload.shape[1], length)
    filled[:, :sent] = payload[:, :sent]
    return filled


def _falls(time_ms: NDArray[np.uint32]) -> NDArray[np.intp]:
    """How often a clock has fallen so far, shape (n,)."""
    return np.cumsum(np.r_[False, time_ms[1:] < time_ms[:-1]][: len(time_ms)])


def _states(heartbeats: Table) -> NDArray[np.int32]:
    """One number for all that a heartbeat says, shape (n,)."""
    kind = heartbeats["autopilot"].astype(np.int32) << 8 | heartbeats["type"]
    return kind << 1 | heartbeats["armed"]


def _without_runs(
    table: Table, value: NDArray[np.generic], repeats: NDArray[np.bool_] | None = None
) -> Table:
    """The rows where a vehicle's value begins or ends a run of equal ones: the rest says nothing new.

    ``repeats`` tells which rows may be left out at all. This keeps memory constant for logs that
    hold no position but many of the other records.
    """
    order = np.argsort(table["vehicle"], kind="stable")
    vehicle, sorted_value = table["vehicle"][order], value[order]
    same = (vehicle[1:] == vehicle[:-1]) & (sorted_value[1:] == sorted_value[:-1])
    inner = np.zeros(len(table), np.bool_)
    inner[order[1:-1]] = same[1:] & same[:-1]
    return table[~inner if repeats is None else ~(inner & repeats)]

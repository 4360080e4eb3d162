"""Records of the three messages that positions are read from, as columns of equal length."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flight_replay.tlog.crc import Flags, Index

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


def joined(parts: list[Records]) -> Records:
    """Records of consecutive parts of a log as one; empties the list, so that they are not held twice."""
    empty: dict[int, int] = {}
    for part in parts:
        for vehicle, count in part.empty.items():
            empty[vehicle] = empty.get(vehicle, 0) + count
    positions = [part.positions for part in parts]
    heartbeats = [part.heartbeats for part in parts]
    fixes = [part.fixes for part in parts]
    parts.clear()
    return Records(_concatenated(positions), _concatenated(heartbeats), _concatenated(fixes), empty)


def _concatenated(parts: list[AnyColumns]) -> AnyColumns:
    """Columns end to end, giving back the memory of each as soon as it is copied."""
    kind = type(parts[0])
    columns = {each.name: [getattr(part, each.name) for part in parts] for each in fields(kind)}
    parts.clear()
    return kind(**{each.name: np.concatenate(columns.pop(each.name)) for each in fields(kind)})

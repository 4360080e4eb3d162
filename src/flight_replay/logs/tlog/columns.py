"""Records of the messages that are read, as columns of equal length."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Indices
from flight_replay.logs.column_buffer import ColumnBuffer

FIX_3D = 3  # GPS_FIX_TYPE_3D_FIX
AnyMessage = TypeVar("AnyMessage", bound="MessageColumns")


@dataclass(frozen=True, slots=True, eq=False)
class MessageColumns:
    """Records of a message in the order of the log, every column of shape (n,).

    ``offset`` is the record's place in the log, ``vehicle`` its system id * 256 + component id.
    """

    offset: NDArray[np.int64]
    vehicle: NDArray[np.uint16]

    def __len__(self) -> int:
        return len(self.offset)

    def select(self: AnyMessage, keep: Flags | Indices) -> AnyMessage:
        """The records that a mask or an index array picks."""
        if keep.dtype == np.bool_:
            if keep.all():
                return self
            keep = keep.nonzero()[0]
        return type(self)(**{each.name: getattr(self, each.name)[keep] for each in fields(self)})


@dataclass(frozen=True, slots=True, eq=False)
class Positions(MessageColumns):
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
    heading_cdeg: NDArray[np.uint16]

    @property
    def is_empty(self) -> Flags:
        """Where latitude and longitude are both 0: no position at all."""
        return np.asarray((self.lat_e7 == 0) & (self.lon_e7 == 0))


@dataclass(frozen=True, slots=True, eq=False)
class Heartbeats(MessageColumns):
    """HEARTBEAT: who sent it (MAV_AUTOPILOT, MAV_TYPE), whether the motors were armed, and the flight mode.

    ``mode`` is the lowest byte of ``custom_mode``, which is all of it for ArduPilot.
    """

    autopilot: NDArray[np.uint8]
    type: NDArray[np.uint8]
    armed: Flags
    mode: NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class GpsStatus(MessageColumns):
    """GPS_RAW_INT or GPS2_RAW: the fix of the first or second receiver.

    ``fix`` is 0 where there is no receiver, 1 without a 3D fix, and 3 with one or better.
    """

    fix: NDArray[np.uint8]

    @property
    def has_3d_fix(self) -> Flags:
        """Whether the receiver had a 3D fix or better (n,)."""
        return np.asarray(self.fix == FIX_3D)


@dataclass(frozen=True, slots=True, eq=False)
class ArmingReports(MessageColumns):
    """STATUSTEXT and COMMAND_ACK that tell of arming or disarming.

    ``armed`` holds ``Armed`` values: what the motors are from then on, "unknown" where it may be either.
    """

    armed: NDArray[np.int8]


@dataclass(frozen=True, slots=True, eq=False)
class Records:
    """What was read; ``empty`` counts the positions at 0, 0 by vehicle.

    ``gps`` is GPS_RAW_INT; ``gps2`` is GPS2_RAW, as far as it was looked for.
    """

    positions: Positions
    heartbeats: Heartbeats
    gps: GpsStatus
    gps2: GpsStatus
    reports: ArmingReports
    empty: dict[int, int]


class RecordBuffer:
    """Puts the records of consecutive parts of a log together."""

    def __init__(self) -> None:
        self._positions = ColumnBuffer(Positions)
        self._heartbeats = ColumnBuffer(Heartbeats)
        self._gps = ColumnBuffer(GpsStatus)
        self._gps2 = ColumnBuffer(GpsStatus)
        self._reports = ColumnBuffer(ArmingReports)
        self._empty: Counter[int] = Counter()

    def add(self, part: Records) -> None:
        """Append a part's records."""
        self._positions.add(part.positions)
        self._heartbeats.add(part.heartbeats)
        self._gps.add(part.gps)
        self._gps2.add(part.gps2)
        self._reports.add(part.reports)
        self._empty.update(part.empty)

    @property
    def records(self) -> Records:
        """All records so far."""
        return Records(
            self._positions.columns,
            self._heartbeats.columns,
            self._gps.columns,
            self._gps2.columns,
            self._reports.columns,
            dict(self._empty),
        )

"""What is kept of a DataFlash log: columns of a few messages in SI units, with each record's offset."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.logs.column_buffer import ColumnBuffer
from flight_replay.logs.dataflash.message_rows import Offsets

AnyTable = TypeVar("AnyTable", bound="LoggedColumns")


@dataclass(frozen=True, slots=True, eq=False)
class LoggedColumns:
    """Records in the order of the log, every column of shape (n,).

    ``time_s`` is that of the autopilot's clock since it booted, not a number where a record has none.
    """

    offset: Offsets
    time_s: Floats

    def __len__(self) -> int:
        return len(self.offset)

    def select(self: AnyTable, keep: Flags | Indices) -> AnyTable:
        """The rows that a mask or an index array picks."""
        if keep.dtype == np.bool_ and keep.all():
            return self
        return type(self)(**{each.name: getattr(self, each.name)[keep] for each in fields(self)})


@dataclass(frozen=True, slots=True, eq=False)
class LoggedPositions(LoggedColumns):
    """POS or GPS. ``above_home_m`` is what the record itself says, not a number where it does not."""

    lat_deg: Floats
    lon_deg: Floats
    amsl_m: NDArray[np.float32]
    above_home_m: NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class GpsPositions(LoggedPositions):
    """GPS: the receiver's number, whether the autopilot used it, its fix, velocity and time.

    ``utc_s`` is Unix time, not a number where the receiver did not know it.
    """

    instance: NDArray[np.int8]
    is_used: Flags
    has_3d_fix: Flags
    ground_speed_m_s: NDArray[np.float32]
    course_deg: NDArray[np.float32]
    down_m_s: NDArray[np.float32]
    utc_s: Floats


@dataclass(frozen=True, slots=True, eq=False)
class LoggedHeadings(LoggedColumns):
    """ATT: where the nose points."""

    heading_deg: NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class LoggedVelocities(LoggedColumns):
    """Velocities of an estimator."""

    north_m_s: NDArray[np.float32]
    east_m_s: NDArray[np.float32]
    down_m_s: NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class ArmEvents(LoggedColumns):
    """EV and ARM: whether the motors were armed or disarmed."""

    armed: Flags


class TableParts:
    """Tables of consecutive parts of a log, joined as they come."""

    def __init__(self) -> None:
        self._buffers: dict[str, ColumnBuffer[Any]] = {}

    def add(self, name: str, part: LoggedColumns) -> None:
        """Append a part to the table of a name, all of which are of one kind."""
        self._buffers.setdefault(name, ColumnBuffer(type(part))).add(part)

    def joined(self, name: str, kind: type[AnyTable]) -> AnyTable:
        """The whole table of a name, without rows if nothing was added; it can be asked for once."""
        buffer = self._buffers.pop(name, None)
        if buffer is None:
            empty: dict[str, Any] = {each.name: _EMPTY[str(each.type)] for each in fields(kind)}
            return kind(**empty)
        table = buffer.columns
        assert isinstance(table, kind)
        return table


_EMPTY = {
    "Offsets": np.zeros(0, np.int64),
    "Floats": np.zeros(0),
    "Flags": np.zeros(0, np.bool_),
    "NDArray[np.float32]": np.zeros(0, np.float32),
    "NDArray[np.int8]": np.zeros(0, np.int8),
}

"""Joins records of other messages to positions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.logs.dataflash.message_rows import Offsets
from flight_replay.logs.dataflash.message_tables import LoggedColumns
from flight_replay.logs.dataflash.row_slices import slices

_FARTHEST_S = 0.5  # one loop of the slowest logger, and then some


def values_near(
    positions: LoggedColumns, others: LoggedColumns, columns: Sequence[NDArray[np.float32]]
) -> Floats:
    """What the records nearest in time to positions (n,) say, shape (n, columns), nan where there are none.

    Args:
        positions: The positions, in the order of the log.
        others: The other records, likewise.
        columns: Columns of these (m,).
    """
    values = np.full((len(positions), len(columns)), np.nan)
    if not len(others):
        return values
    for part in slices(len(positions)):
        nearest = _nearest_in_time(positions.offset[part], positions.time_s[part], others)
        for number, column in enumerate(columns):
            values[part, number] = np.where(nearest >= 0, column[nearest], np.nan)
    return values


def _nearest_in_time(offset: Offsets, time_s: Floats, others: LoggedColumns) -> Indices:
    """The record nearest in time to each position (n,), -1 where there is none within half a second.

    It is one of two: the last before and the first behind the position in the log.

    Args:
        offset: Where the positions are in the log (n,), in order.
        time_s: Their times (n,).
        others: The other records, in the order of the log, one at least.
    """
    behind = np.searchsorted(others.offset, offset)
    before = np.maximum(behind - 1, 0)
    behind = np.minimum(behind, len(others) - 1)
    before_s, behind_s = (
        np.nan_to_num(np.abs(others.time_s[each] - time_s), nan=np.inf) for each in (before, behind)
    )
    nearest = np.where(behind_s < before_s, behind, before)
    return np.where(np.minimum(before_s, behind_s) <= _FARTHEST_S, nearest, -1)

"""Joins records of other messages to positions."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Indices
from flight_replay.logs.dataflash.message_tables import LoggedColumns

_FARTHEST_S = 0.5  # one loop of the slowest logger, and then some


def nearest_in_time(positions: LoggedColumns, others: LoggedColumns) -> Indices:
    """The record nearest in time to each position (n,), -1 where there is none within half a second.

    It is one of two: the last before and the first behind the position in the log.

    Args:
        positions: The positions, in the order of the log.
        others: The other records, likewise.
    """
    if not len(others):
        return np.full(len(positions), -1)
    behind = np.searchsorted(others.offset, positions.offset)
    before = np.maximum(behind - 1, 0)
    behind = np.minimum(behind, len(others) - 1)
    before_s, behind_s = (
        np.nan_to_num(np.abs(others.time_s[each] - positions.time_s), nan=np.inf) for each in (before, behind)
    )
    nearest = np.where(behind_s < before_s, behind, before)
    return np.where(np.minimum(before_s, behind_s) <= _FARTHEST_S, nearest, -1)

"""Which positions a vehicle sent while none of its GPS receivers had a 3D fix."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.logs.tlog.columns import GpsStatus, MessageColumns, Positions

_LAST_STATUS_HOLDS_S = 10.0  # some logs tell of the receiver just once, before it has a fix


def lacks_3d_fix(positions: Positions, gps: GpsStatus, gps2: GpsStatus, time_s: Floats) -> Flags:
    """Whether no receiver of the vehicle had a 3D fix at a position, by the last status of each, shape (n,).

    Where the first one says nothing, it is taken to have one. A vehicle that never had a receiver knows its
    place by other means, such as cameras.

    Args:
        positions: Positions, one vehicle's after the other's.
        gps: Status of first receivers, likewise.
        gps2: Status of second receivers, likewise.
        time_s: The vehicles' clocks (n,).
    """
    lacks = _last_is(~gps.has_3d_fix, positions, gps, time_s)
    if len(gps2):
        lacks &= ~_last_is(gps2.has_3d_fix, positions, gps2, time_s)
    have_one = np.concatenate([gps.vehicle[gps.fix > 0], gps2.vehicle[gps2.fix > 0]])
    return lacks & np.isin(positions.vehicle, have_one)


def _last_is(wanted: Flags, positions: Positions, gps: GpsStatus, time_s: Floats) -> Flags:
    """Whether the last status of the same vehicle before a position is a wanted one (m,), shape (n,).

    A status holds until the next one; a vehicle's last one for a while only, counted from the
    position that follows it.
    """
    begin = np.searchsorted(_vehicle_and_offset(positions), _vehicle_and_offset(gps))
    end = np.append(begin[1:], 0)
    last = np.flatnonzero(np.diff(gps.vehicle.astype(np.int64), append=-1))
    end[last] = np.searchsorted(positions.vehicle, gps.vehicle[last], "right")
    for at in last[wanted[last] & (begin[last] < end[last])].tolist():
        following_s = np.maximum.accumulate(time_s[begin[at] : end[at]])
        end[at] = begin[at] + np.searchsorted(following_s, following_s[0] + _LAST_STATUS_HOLDS_S, "right")
    n = len(positions)
    begun, ended = (np.bincount(at[wanted], minlength=n + 1)[:n] for at in (begin, end))
    return np.asarray(np.cumsum(begun - ended) > 0)


def _vehicle_and_offset(columns: MessageColumns) -> NDArray[np.int64]:
    """One ascending number for each record (n,)."""
    return columns.vehicle.astype(np.int64) << 47 | columns.offset

"""Heartbeats that may come late, as positions do around them: they show a state that has passed.

Heartbeats carry no time, so one that shows a state anew which was just left may be an old one. It counts
once that state was left for longer than anything near it comes late.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.tlog.clock.late_records import LONGEST_LAG_S

Offsets = NDArray[np.int64]

_NEAR_S = 5  # at least so close before or behind a heartbeat a late position tells that it may be late
_SLACK_S = 1.0  # heartbeats come once a second


@dataclass(frozen=True, slots=True, eq=False)
class Arrivals:
    """When a vehicle's positions came, and how late.

    ``clock_s`` is the latest time that any position up to an ``offset`` in the log told, both (n,) and
    ascending; ``late_s`` is how far one was behind that at most in a ``cell`` of ``_NEAR_S``, both (m,).
    """

    offset: Offsets
    clock_s: Floats
    cell: NDArray[np.int64]
    late_s: Floats

    def time_s(self, offset: Offsets) -> Floats:
        """The latest time that positions told before some places in the log (k,)."""
        return self.clock_s[np.maximum(np.searchsorted(self.offset, offset) - 1, 0)]

    def hold_s(self, time_s: Floats) -> Floats:
        """How long a state that was left may still be shown, at some times (k,); 0 where nothing is late."""
        cell, hold_s = (time_s // _NEAR_S).astype(np.int64), np.zeros(len(time_s))
        for near in (cell - 1, cell, cell + 1):
            at = np.searchsorted(self.cell, near)
            is_late = self.cell.take(at, mode="clip") == near
            late_s = self.late_s.take(at, mode="clip") + _SLACK_S
            hold_s = np.where(is_late, np.maximum(hold_s, late_s), hold_s)
        return hold_s

    def ahead_of(self, time_s: float) -> int:
        """The place in the log just ahead of the first position that came at a time or later."""
        return int(self.offset[np.searchsorted(self.clock_s, time_s)]) - 1


def arrivals(offset: Offsets, time_s: Floats) -> Arrivals | None:
    """When positions came; None if none came late.

    Args:
        offset: Where a vehicle's positions are in the log (n,), ascending.
        time_s: What they tell of the time (n,).
    """
    clock_s = np.maximum.accumulate(time_s)
    late_s = clock_s - time_s
    late = np.flatnonzero((late_s > 0) & (late_s <= LONGEST_LAG_S))
    if not len(late):
        return None
    cell = (clock_s[late] // _NEAR_S).astype(np.int64)
    first = np.flatnonzero(np.diff(cell, prepend=cell[0] - 1))
    return Arrivals(offset, clock_s, cell[first], np.maximum.reduceat(late_s[late], first))


def without_late(
    state: NDArray[np.uint8], offset: Offsets, came: Arrivals
) -> tuple[NDArray[np.uint8], Offsets]:
    """The states of a vehicle from places in the log on, without those that may be shown late.

    Args:
        state: The state that each heartbeat shows (k,); of equal ones in a row the first and last do.
        offset: Where it is in the log (k,), ascending.
        came: When the vehicle's positions came.
    """
    time_s = came.time_s(offset)
    states, times_s, holds_s = state.tolist(), time_s.tolist(), came.hold_s(time_s).tolist()
    state, offset = state.copy(), offset.copy()
    left_s: dict[int, float] = {}  # when each state was left
    now = states[0] if states else 0
    for at, shown in enumerate(states):
        if shown == now:
            continue
        was_left_s = left_s.get(shown, -np.inf)
        since_s = max(was_left_s + holds_s[at], times_s[at])
        if since_s > times_s[at]:  # it may be late, but not if the state lasts
            last = at + 1 if states[at + 1 : at + 2] == [shown] else at
            if times_s[last] < was_left_s + holds_s[last]:
                state[at] = now
                continue
            since_s = min(since_s, times_s[last])
            offset[at] = came.ahead_of(since_s)
        left_s[now], now = since_s, shown
    return state, offset

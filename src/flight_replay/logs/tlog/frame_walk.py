"""Finds MAVLink records in bytes, as a walk over every byte offset would.

The walk: at each offset, a frame whose header, length and CRC are right is a record and is
skipped whole; anything else is skipped by one byte. So a frame inside another frame's payload
is no record. Here the same is found without walking: only those wanted frames that another one
could hide are looked at closely (``hidden.py``).
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Bytes, Flags, Indices
from flight_replay.logs.tlog import message_table
from flight_replay.logs.tlog.crc import have_right_crc, rows_at
from flight_replay.logs.tlog.frames import ROW_LENGTH, STAMP_LENGTH, Candidates, Marked
from flight_replay.logs.tlog.nested_frames import find_hidden, header_length, is_right_at

_FEW = 8  # frames that are not worth columns


class Walk:
    """The walk over marked bytes: it comes to ``enter``, and ends at ``stop`` or behind."""

    def __init__(self, marked: Marked, enter: int, stop: int) -> None:
        self.enter = enter
        self._data = marked.data
        self._stop = max(stop, enter)
        first = np.searchsorted(marked.reaching.start, enter)
        self._starts, self._ends = marked.reaching.start[first:], marked.reaching.end[first:]
        self._reach = np.maximum.accumulate(np.append(np.intp(0), self._ends))

    def finds(self, candidates: Candidates, message: int) -> Flags:
        """Whether candidates of a message (n,), none before ``enter``, are records."""
        right = are_right(self._data, candidates, message)
        right[right] = self.visits(candidates.start[right])
        return right

    def visits(self, starts: Indices) -> Flags:
        """Whether the walk comes to right frames (n,), none before ``enter``: no record hides them."""
        reached = self._reach.take(np.searchsorted(self._starts, starts)) > starts
        suspects = starts[reached].tolist()
        hidden = self._hidden(suspects)[0] if suspects else set()
        return ~np.isin(starts, list(hidden)) if hidden else np.ones(len(starts), np.bool_)

    @property
    def leave(self) -> int:
        """Where the walk goes on: where it was to stop, or behind the record that reaches over that."""
        return self._hidden([])[1]

    def _hidden(self, suspects: list[int]) -> tuple[set[int], int]:
        return find_hidden(self._data, self._starts, self._ends, suspects, self._stop)


def are_right(data: Bytes, candidates: Candidates, message: int) -> Flags:
    """Whether the CRC of each candidate of a message (n,) is right.

    Frames of the same version and length are checked together, but where there are few of them,
    which are most likely none.
    """
    start, rows = candidates.start, candidates.rows
    extra = int(message_table.EXTRAS[message])
    right = np.zeros(len(start), np.bool_)
    shape = rows[:, STAMP_LENGTH + 1].astype(np.intp)
    shape[rows[:, STAMP_LENGTH] == message_table.MAVLINK1_MARK] += 256
    counts = np.bincount(shape, minlength=1)
    few = np.flatnonzero((counts <= _FEW).take(shape))
    right[few] = [is_right_at(data, place) for place in start.take(few).tolist()]
    for common in np.flatnonzero(counts > _FEW).tolist():
        alike = np.flatnonzero(shape == common) if counts[common] < len(start) else slice(None)
        length = 1 + header_length(common >= 256) + common % 256 + 2
        if STAMP_LENGTH + length <= ROW_LENGTH:
            frames = rows[alike, STAMP_LENGTH : STAMP_LENGTH + length]
        else:
            frames = rows_at(data, start[alike], length)
        right[alike] = have_right_crc(frames, extra)
    return right

"""Finds MAVLink records in bytes, as a walk over every byte offset would.

The walk: at each offset, a frame whose header, length and CRC are valid is a record and is
skipped whole; anything else is skipped by one byte. So a frame inside another frame's payload
is no record. Here the same is found without walking, by looking back from the wanted frames for
others around them (``nested_frames.py``).
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Bytes, Flags, Indices
from flight_replay.logs.tlog.frames import Candidates, valid_frames
from flight_replay.logs.tlog.nested_frames import Enclosures, enclosing_frames, possible_enclosures, walk


class Walk:
    """The walk over bytes of a log, which end at ``end``: it comes in at ``enter``, and stops at ``stop``."""

    def __init__(self, data: Bytes, enter: int, stop: int, end: int) -> None:
        self.enter = enter
        self._data, self._stop, self._end = data, max(stop, enter), end

    def visits(self, starts: Indices, possible: Enclosures | None = None) -> Flags:
        """Whether the walk comes to valid frames (n,), none before ``enter``: they are in no record.

        Args:
            starts: Where the frames begin, in ascending order.
            possible: What may be frames around these, and around others, where that is known already.
        """
        frames = self._around(possible.of(starts) if possible else possible_enclosures(self._data, starts))
        hidden, _ = walk(frames, starts.tolist()) if frames else (set(), 0)
        return ~np.isin(starts, list(hidden)) if hidden else np.ones(len(starts), np.bool_)

    def visits_valid(self, candidates: Candidates, message: int, possible: Enclosures | None = None) -> Flags:
        """Which candidates of a message (n,) are valid frames that the walk comes to.

        Args:
            candidates: The candidates.
            message: The message.
            possible: As for ``visits``.
        """
        are_records = valid_frames(self._data, candidates, message) & (candidates.start >= self.enter)
        are_records[are_records] = self.visits(candidates.start[are_records], possible)
        return are_records

    @property
    def leave(self) -> int:
        """Where the walk goes on: where it was to stop, or behind the record around that place."""
        frames = self._around(possible_enclosures(self._data, np.array([self._stop])))
        return max(walk(frames, ())[1], self._stop)

    def _around(self, possible: Enclosures) -> dict[int, int]:
        return enclosing_frames(self._data, possible, self.enter, self._end)

"""The bytes of a log in blocks, with what may be frames in them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Bytes
from flight_replay.logs.byte_source import Stream
from flight_replay.logs.tlog.byte_rows import rows_at
from flight_replay.logs.tlog.frame_search import FrameSearch
from flight_replay.logs.tlog.frames import ROW_LENGTH, STAMP_LENGTH, Candidates, frame_lengths
from flight_replay.logs.tlog.message_table import GLOBAL_POSITION_INT, GPS_RAW_INT, HEARTBEAT, LONGEST_FRAME
from flight_replay.logs.tlog.nested_frames import LOOK_BACK, Enclosures, joined, possible_enclosures

SLICE_LENGTH = 1 << 21  # bytes searched at a time: more leave the cache, fewer cost more calls
_MESSAGES = GLOBAL_POSITION_INT, HEARTBEAT, GPS_RAW_INT
_LEAD = STAMP_LENGTH + LOOK_BACK  # bytes before a block that are looked at with it
_MARGIN = LONGEST_FRAME + ROW_LENGTH  # bytes behind a block that its frames may need


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """A part of a log, up to ``stop``, in bytes that reach to ``end`` and that the next block uses again.

    Indices count from the beginning of ``data``, which is at ``offset`` in the log. The candidates
    are those of GLOBAL_POSITION_INT, HEARTBEAT and GPS_RAW_INT; ``enclosures`` are what may be frames
    around the first.
    """

    data: Bytes
    offset: int
    stop: int
    end: int
    positions: Candidates
    heartbeats: Candidates
    gps: Candidates
    enclosures: Enclosures


def read_blocks(stream: Stream, block_length: int) -> Iterator[Block]:
    """The blocks of a stream, of which there is one at least."""
    window = _Window(stream, block_length)
    search = FrameSearch(_MESSAGES)
    while True:
        yield _searched(window, search)
        if window.is_last:
            return
        window.advance()


def _searched(window: _Window, search: FrameSearch) -> Block:
    """The block in a window. What is needed of its bytes is copied slice by slice, out of the cache."""
    data = window.data
    found: list[list[Candidates]] = [[] for _ in _MESSAGES]
    enclosures = []
    for start, stop in window.slices():
        starts = search.find(data, start, stop)
        for candidates, its in zip(found, starts, strict=True):
            candidates.append(Candidates(its, rows_at(data, its - STAMP_LENGTH, ROW_LENGTH)))
        enclosures.append(possible_enclosures(data, starts[0]))
    positions, heartbeats, gps = (_whole(candidates, window.end) for candidates in found)
    all_enclosures = joined(enclosures)
    return Block(data, window.offset, window.stop, window.end, positions, heartbeats, gps, all_enclosures)


def _whole(parts: list[Candidates], end: int) -> Candidates:
    """The candidates of all parts, but for those that reach over the end of the log."""
    start = np.concatenate([part.start for part in parts])
    candidates = Candidates(start, np.concatenate([part.rows for part in parts]))
    near_end = np.arange(np.searchsorted(start, end - LONGEST_FRAME), len(start))
    stop = start[near_end] + frame_lengths(candidates.rows[near_end, STAMP_LENGTH:])
    if (stop <= end).all():
        return candidates
    return candidates.take(np.delete(np.arange(len(start)), near_end[stop > end]))


class _Window:
    """Bytes of a stream: a block and what is around it, with zeros before and behind the log.

    The block is between ``_LEAD`` and ``stop``; the bytes of the log end at ``end``; the first byte is
    that at ``offset`` in the log.
    """

    def __init__(self, stream: Stream, block_length: int) -> None:
        self._stream = stream
        self._ended = False
        self._full = _LEAD + block_length
        self.data: Bytes = np.zeros(self._full + _MARGIN, np.uint8)
        self.end = _LEAD
        self.offset = -_LEAD

    @property
    def stop(self) -> int:
        return min(self.end, self._full)

    @property
    def is_last(self) -> bool:
        return self._ended and self.end <= self._full

    def slices(self) -> Iterator[tuple[int, int]]:
        """Start and stop of each slice of the block, of which there is one at least, read just before."""
        for start in range(_LEAD, self._full, SLICE_LENGTH):
            stop = min(start + SLICE_LENGTH, self._full)
            self._read(stop + _MARGIN)
            yield start, max(min(stop, self.end), start)
            if self.end < stop:
                return

    def advance(self) -> None:
        """Go on to the next block."""
        kept = self.data[self._full - _LEAD : self.end].copy()
        self.data[: len(kept)] = kept
        self.end = len(kept)
        self.offset += self._full - _LEAD

    def _read(self, until: int) -> None:
        while not self._ended and self.end < until:
            got = self._stream.readinto(self.data[self.end : until].data)
            self.end += got
            self._ended = got == 0
        self.data[self.end : until] = 0

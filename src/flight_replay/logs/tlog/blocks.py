"""The bytes of a log in blocks, each with what it holds of the bytes around it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from flight_replay.logs.tlog import message_table
from flight_replay.logs.tlog.byte_source import Stream
from flight_replay.logs.tlog.columns import Records
from flight_replay.logs.tlog.decode import decode
from flight_replay.logs.tlog.frame_walk import Walk
from flight_replay.logs.tlog.frames import SLICE_LENGTH, STAMP_LENGTH, Span, Window, mark
from flight_replay.logs.tlog.records import read_records

_WANTED = message_table.GLOBAL_POSITION_INT, message_table.HEARTBEAT, message_table.GPS_RAW_INT
_LEAD = STAMP_LENGTH  # the stamp of a record that begins a block
_MARGIN = message_table.LONGEST_FRAME + 16  # what headers and frames may need behind a block


@dataclass(frozen=True, slots=True)
class Block:
    """Bytes ``offset`` to ``stop`` of a log, in a window that the next block will use again."""

    offset: int
    stop: int
    _window: Window
    _slices: Iterable[Span]

    def read(self, enter: int) -> tuple[Records, int]:
        """The records that a walk finds which comes to ``enter``, and where it goes on, places in the log."""
        base = self.offset - _LEAD
        marked = mark(self._window, self._slices, _WANTED)
        walk = Walk(marked, enter - base, self.stop - base)
        return read_records(decode(marked), walk, base), walk.leave + base


def blocks_of_file(descriptor: int, begin: int, end: int, block_length: int) -> Iterator[Block]:
    """The blocks of a plain file's bytes ``begin`` to ``end``."""
    window = Window(_LEAD + min(block_length, end - begin) + _MARGIN)
    for offset in range(begin, end, block_length):
        stop = min(offset + block_length, end)
        yield Block(offset, stop, window, _read_slices(window, descriptor, offset, stop))


def _read_slices(window: Window, descriptor: int, offset: int, stop: int) -> Iterator[Span]:
    """Read a block with its surroundings, and yield each slice as soon as it is there and in the cache.

    Before the log's beginning and behind its end there are zeros.
    """
    held = max(_LEAD - offset, 0)
    window.data[:held] = 0
    block_stop = stop - offset + _LEAD
    for start in range(_LEAD, block_stop, SLICE_LENGTH):
        slice_stop = min(start + SLICE_LENGTH, block_stop)
        behind = slice_stop + _MARGIN
        while held < behind and (
            got := os.preadv(descriptor, [window.data[held:behind].data], offset - _LEAD + held)
        ):
            held += got
        window.data[held:behind] = 0
        yield Span(start, max(min(slice_stop, held), start), held)


def blocks_of_stream(stream: Stream, block_length: int) -> Iterator[Block]:
    """The blocks of bytes that come in order, each keeping what the next one needs."""
    window = Window(_LEAD + block_length + _MARGIN)
    held, offset, ended = _LEAD, 0, False
    while True:
        if not ended:
            held, ended = _fill(window, stream, held)
        window.data[held : held + _MARGIN] = 0
        stop = min(held, _LEAD + block_length)
        starts = range(_LEAD, stop, SLICE_LENGTH)
        slices = [Span(start, min(start + SLICE_LENGTH, stop), held) for start in starts]
        yield Block(offset, offset + stop - _LEAD, window, slices)
        if ended and stop == held:
            return
        window.data[: held - block_length] = window.data[block_length:held].copy()
        held -= block_length
        offset += block_length


def _fill(window: Window, stream: Stream, held: int) -> tuple[int, bool]:
    """Read behind the ``held`` bytes until the window is full or the stream ends."""
    while held < len(window.data):
        data = stream.read(len(window.data) - held)
        if not data:
            return held, True
        window.data[held : held + len(data)] = np.frombuffer(data, np.uint8)
        held += len(data)
    return held, False

"""Reads a log block by block, in memory that does not grow with it, and a plain file on several cores."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flight_replay.tlog import messages
from flight_replay.tlog.columns import Gathered, Records
from flight_replay.tlog.decode import decode
from flight_replay.tlog.frames import SLICE_LENGTH, Marked, Span, Walk, Window, mark
from flight_replay.tlog.source import Source, Stream

if TYPE_CHECKING:
    from concurrent.futures import Future

Progress = Callable[[int, int], None]

BLOCK_LENGTH = 8 << 20
_WANTED = np.zeros(256, np.bool_)
_WANTED[[messages.GLOBAL_POSITION_INT, messages.HEARTBEAT, messages.GPS_RAW_INT]] = True
_LEAD = 8  # the stamp of a record that begins a block
_MARGIN = messages.LONGEST_FRAME + 16  # what headers and frames may need behind a block
_MOST_THREADS = 4


@dataclass(frozen=True, slots=True)
class _Block:
    """Bytes ``offset`` to ``stop`` of a log, whose start marks were found in a window."""

    offset: int
    stop: int
    window: Window
    marked: Marked

    def read(self, enter: int) -> tuple[Records, int]:
        """The records that a walk finds which comes to ``enter``, and where it goes on, places in the log."""
        base = self.offset - _LEAD
        walk = Walk(self.marked, enter - base, self.stop - base)
        return decode(walk, base), walk.leave + base


def scan(
    source: Source, progress: Progress | None = None, block_length: int = BLOCK_LENGTH
) -> tuple[Records, int]:
    """All records of a log, and its length in bytes, unpacked."""
    if source.descriptor is None:
        blocks = _blocks_of_stream(source.stream, block_length)
    else:
        blocks = _blocks_of_file(source.descriptor, source.size, block_length)
    gathered, enter, length = Gathered(), 0, 0
    for block in blocks:
        records, enter = block.read(enter)
        gathered.add(records)
        length = block.stop
        if progress:
            progress(source.position or length, source.size)
    return gathered.records, length


def _blocks_of_file(descriptor: int, size: int, block_length: int) -> Iterator[_Block]:
    """The blocks of a plain file."""
    spare: list[Window] = []

    def block(offset: int) -> _Block:
        try:
            window = spare.pop()
        except IndexError:
            window = Window(_LEAD + min(block_length, size) + _MARGIN)
        stop = min(offset + block_length, size)
        slices = _read_slices(window, descriptor, offset, stop)
        return _Block(offset, stop, window, mark(window, slices, _WANTED))

    for each in _ahead(block, range(0, size, block_length)):
        yield each
        spare.append(each.window)


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


def _ahead(block: Callable[[int], _Block], offsets: range) -> Iterator[_Block]:
    """The blocks in order, several being worked on at a time: numpy lets threads run side by side.

    Only the long steps over all bytes are given to threads, for the many short ones over records
    would wait for each other.
    """
    threads = min(_MOST_THREADS, os.cpu_count() or 1, len(offsets))
    if threads == 1:
        yield from map(block, offsets)
        return
    from concurrent.futures import ThreadPoolExecutor  # small logs go without its start-up time

    with ThreadPoolExecutor(threads) as pool:
        waiting: deque[Future[_Block]] = deque()
        for offset in offsets:
            waiting.append(pool.submit(block, offset))
            if len(waiting) > threads:
                yield waiting.popleft().result()
        for future in waiting:
            yield future.result()


def _blocks_of_stream(stream: Stream, block_length: int) -> Iterator[_Block]:
    """The blocks of bytes that come in order, each keeping what the next one needs."""
    window = Window(_LEAD + block_length + _MARGIN)
    held, offset, ended = _LEAD, 0, False
    while True:
        if not ended:
            held, ended = _fill(window, stream, held)
        window.data[held : held + _MARGIN] = 0
        stop = min(held, _LEAD + block_length)
        starts = range(_LEAD, stop, SLICE_LENGTH)
        slices = (Span(start, min(start + SLICE_LENGTH, stop), held) for start in starts)
        yield _Block(offset, offset + stop - _LEAD, window, mark(window, slices, _WANTED))
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

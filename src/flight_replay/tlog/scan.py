"""Reads a log block by block, in memory that does not grow with it, and a plain file on several cores."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flight_replay.tlog import messages
from flight_replay.tlog.columns import Records, decode, joined
from flight_replay.tlog.frames import Span, Window, find_records
from flight_replay.tlog.source import Source, Stream

if TYPE_CHECKING:
    from concurrent.futures import Future

Progress = Callable[[int, int], None]

BLOCK_LENGTH = 4 << 20
_NOTHING = np.zeros(256, np.bool_)
_WANTED = _NOTHING.copy()
_WANTED[[messages.GLOBAL_POSITION_INT, messages.HEARTBEAT, messages.GPS_RAW_INT]] = True
_LEAD = 1024  # what is looked at before a block to guess where the walk enters it
_FIRST_SEEN = 8  # where the look begins, a stamp behind the first byte that is there
_MARGIN = messages.LONGEST_FRAME + 16  # what headers and frames may need behind a block
_MOST_THREADS = 4


@dataclass(frozen=True, slots=True)
class Part:
    """A block's records, and where the walk enters the block and goes on behind it, offsets into the log."""

    records: Records
    enter: int
    leave: int


def scan(
    source: Source, progress: Progress | None = None, block_length: int = BLOCK_LENGTH
) -> tuple[Records, int]:
    """All records of a log, and its length in bytes, unpacked."""
    if source.descriptor is None:
        parts = _parts_of_stream(source.stream, block_length)
    else:
        parts = _parts_of_file(source.descriptor, source.size, block_length)
    records, length = [], 0
    for part, length in parts:
        records.append(part.records)
        if progress:
            progress(source.position or length, source.size)
    return joined(records), length


@dataclass(frozen=True, slots=True)
class _Block:
    """Bytes ``offset`` to ``stop`` of a log, with what is in front and behind; the data ends at ``end``."""

    window: Window
    offset: int
    stop: int
    end: int

    @property
    def base(self) -> int:
        """Where in the log the window begins."""
        return self.offset - _LEAD

    def guess(self) -> int:
        """Where the walk probably enters, taking it to have come through the lead's beginning."""
        lead = Span(_FIRST_SEEN, _LEAD, self.end - self.base)
        return find_records(self.window, lead, _NOTHING)[1] + self.base

    def read(self, enter: int) -> Part:
        """The records that a walk finds which enters the block at ``enter``."""
        span = Span(enter - self.base, max(self.stop, enter) - self.base, self.end - self.base)
        frames, leave = find_records(self.window, span, _WANTED)
        return Part(decode(self.window.data, self.base, frames), enter, leave + self.base)


def _parts_of_file(descriptor: int, size: int, block_length: int) -> Iterator[tuple[Part, int]]:
    """The parts of a plain file, and where each ends.

    Blocks are read ahead on a guess of where the walk enters; where it was wrong, once more.
    """
    spare: list[Window] = []

    def part(offset: int, enter: int | None) -> Part:
        window = spare.pop() if spare else Window(_LEAD + block_length + _MARGIN)
        block = _load(window, descriptor, offset, min(offset + block_length, size))
        found = block.read(block.guess() if enter is None else enter)
        spare.append(window)
        return found

    enter = 0
    for offset, guessed in _ahead(part, range(0, size, block_length)):
        found = guessed if guessed.enter == enter else part(offset, enter)
        enter = found.leave
        yield found, min(offset + block_length, size)


def _load(window: Window, descriptor: int, offset: int, stop: int) -> _Block:
    """Read a block with its surroundings; before the beginning and behind the end there are zeros."""
    missing = max(_LEAD - offset, 0)
    window.data[:missing] = 0
    begin = offset - _LEAD + missing
    got = os.preadv(descriptor, [window.data[missing:].data], begin)
    window.data[missing + got :] = 0
    return _Block(window, offset, max(min(stop, begin + got), offset), begin + got)


def _ahead(part: Callable[[int, int | None], Part], offsets: range) -> Iterator[tuple[int, Part]]:
    """The parts in order, several being worked on at a time: numpy lets threads run side by side."""
    threads = min(_MOST_THREADS, os.cpu_count() or 1, len(offsets))
    if threads == 1:
        yield from ((offset, part(offset, None)) for offset in offsets)
        return
    from concurrent.futures import ThreadPoolExecutor  # small logs go without its start-up time

    with ThreadPoolExecutor(threads) as pool:
        waiting: deque[tuple[int, Future[Part]]] = deque()
        for offset in offsets:
            waiting.append((offset, pool.submit(part, offset, None)))
            if len(waiting) > 2 * threads:
                done, future = waiting.popleft()
                yield done, future.result()
        for done, future in waiting:
            yield done, future.result()


def _parts_of_stream(stream: Stream, block_length: int) -> Iterator[tuple[Part, int]]:
    """The parts of bytes that come in order, and where each ends."""
    window = Window(_LEAD + block_length + _MARGIN)
    held, offset, enter = _LEAD, 0, 0
    while True:
        held, ended = _fill(window, stream, held)
        end = offset + held - _LEAD
        stop = end if ended else offset + block_length
        found = _Block(window, offset, stop, end).read(enter)
        enter = found.leave
        yield found, stop
        if ended:
            return
        window.data[: held - block_length] = window.data[block_length:held].copy()
        held -= block_length
        offset += block_length


def _fill(window: Window, stream: Stream, held: int) -> tuple[int, bool]:
    """Read behind the ``held`` bytes until the window is full or the stream ends."""
    while held < len(window.data):
        data = stream.read(len(window.data) - held)
        if not data:
            window.data[held:] = 0
            return held, True
        window.data[held : held + len(data)] = np.frombuffer(data, np.uint8)
        held += len(data)
    return held, False

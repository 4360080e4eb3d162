"""Reads a log block by block, on all cores where the log is a plain file, in memory that does not grow with it."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flight_replay.tlog import messages
from flight_replay.tlog.columns import Records, decode, joined
from flight_replay.tlog.crc import Bytes
from flight_replay.tlog.frames import find_records
from flight_replay.tlog.source import Source, Stream

if TYPE_CHECKING:
    from concurrent.futures import Future

Progress = Callable[[int, int], None]

BLOCK_LENGTH = 4 << 20
_WANTED = (messages.GLOBAL_POSITION_INT, messages.HEARTBEAT, messages.GPS_RAW_INT)
_MARGIN = messages.LONGEST_FRAME + 16  # what a header and a frame may need behind a block
_LEAD = 1024  # what is looked at before a block to guess where the walk enters it
_STAMP_ROOM = 8
_MOST_THREADS = 4


@dataclass(frozen=True, slots=True)
class _Part:
    """A block's records, and where the walk entered it and left it, offsets into the log."""

    records: Records
    entered: int
    left: int


def scan(
    source: Source, progress: Progress | None = None, block_length: int = BLOCK_LENGTH
) -> tuple[Records, int]:
    """All records of a log, and its length in bytes (of what was packed, where it was)."""
    if source.descriptor is not None:
        parts = _parts_of_file(source.descriptor, source.size, block_length)
    else:
        parts = _parts_of_stream(source.stream, block_length)
    records, length = [], 0
    for part, length in parts:
        records.append(part.records)
        if progress:
            progress(source.position or length, source.size)
    return joined(records), length


def _read_block(block: Bytes, lead: int, offset: int, stop: int, end: int, entered: int | None) -> _Part:
    """Walk the log's bytes from ``offset`` to ``stop``, of which ``block`` holds ``lead`` more in front.

    Without knowing where the walk enters (``entered``), it is taken to visit the block's first
    byte, which is nearly always enough for it to be right by ``offset``.
    """
    base = offset - lead
    if entered is None:
        _, guess = find_records(block, _STAMP_ROOM, lead, end - base, ())
    else:
        guess = entered - base
    groups, left = find_records(block, guess, max(stop - base, guess), end - base, _WANTED)
    return _Part(decode(block, base, groups), guess + base, left + base)


def _parts_of_file(descriptor: int, size: int, block_length: int) -> Iterator[tuple[_Part, int]]:
    """The parts of a plain file, read ahead by several threads: numpy works beside Python."""
    offsets = range(0, size, block_length)

    def part(offset: int, entered: int | None) -> _Part:
        block = np.zeros(_LEAD + block_length + _MARGIN, np.uint8)
        missing = max(_LEAD - offset, 0)  # the first block has nothing in front
        got = os.preadv(descriptor, [memoryview(block)[missing:]], offset - _LEAD + missing)
        end = min(offset - _LEAD + missing + got, size)
        return _read_block(block, _LEAD, offset, min(offset + block_length, end), end, entered)

    enters = 0
    for offset, found in _ahead(part, offsets):
        checked = found if found.entered == enters else part(offset, enters)
        enters = checked.left
        yield checked, min(offset + block_length, size)


def _ahead(part: Callable[[int, int | None], _Part], offsets: range) -> Iterator[tuple[int, _Part]]:
    """The parts in order, each worked on before it is asked for."""
    threads = min(_MOST_THREADS, os.cpu_count() or 1, len(offsets))
    if threads == 1:
        yield from ((offset, part(offset, None)) for offset in offsets)
        return
    from concurrent.futures import ThreadPoolExecutor  # noqa: PLC0415 - small logs go without its start-up time

    with ThreadPoolExecutor(threads) as pool:
        waiting: deque[tuple[int, Future[_Part]]] = deque()
        for offset in offsets:
            waiting.append((offset, pool.submit(part, offset, None)))
            if len(waiting) > threads + 1:
                done, future = waiting.popleft()
                yield done, future.result()
        for done, future in waiting:
            yield done, future.result()


def _parts_of_stream(stream: Stream, block_length: int) -> Iterator[tuple[_Part, int]]:
    """The parts of bytes that come in order, each block keeping what the next one looks back at."""
    block = np.zeros(_LEAD + block_length + _MARGIN, np.uint8)
    held, offset, enters = _LEAD, 0, 0
    while True:
        ended = False
        while held < len(block) and not ended:
            data = stream.read(len(block) - held)
            block[held : held + len(data)] = np.frombuffer(data, np.uint8)
            held += len(data)
            ended = not data
        block[held:] = 0
        end = offset + held - _LEAD
        stop = end if ended else offset + block_length
        found = _read_block(block, _LEAD, offset, stop, end, enters)
        enters = found.left
        yield found, min(stop, end)
        if ended:
            return
        block[: held - block_length] = block[block_length:held].copy()
        held -= block_length
        offset += block_length

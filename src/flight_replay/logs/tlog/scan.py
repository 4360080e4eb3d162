"""Reads a log's records in memory that does not grow with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from flight_replay.logs.tlog.blocks import Block, blocks_of_file, blocks_of_stream
from flight_replay.logs.tlog.byte_source import Source
from flight_replay.logs.tlog.columns import Gathered, Records
from flight_replay.logs.tlog.parallel import Part, read_parts

Progress = Callable[[int, int], None]

BLOCK_LENGTH = 16 << 20
_APPROACH = 1 << 16  # bytes before a part that tell, all but surely, where the walk comes into it


def scan(
    source: Source, progress: Progress | None = None, block_length: int = BLOCK_LENGTH
) -> tuple[Records, int]:
    """All records of a log, and its length in bytes, unpacked."""
    tell = progress or (lambda done, size: None)
    if source.descriptor is None:
        blocks = blocks_of_stream(source.stream, block_length)
        part = _read(blocks, 0, lambda stop: tell(source.position, source.size))
        return part.records, part.stop
    return _scan_file(source.descriptor, source.size, tell, block_length), source.size


def _scan_file(descriptor: int, size: int, tell: Progress, block_length: int) -> Records:
    """All records of a plain file.

    A part is read without knowing those before it by taking it that the walk comes in where a short
    walk up to it does.
    """

    def blocks(begin: int, end: int) -> Iterable[Block]:
        return blocks_of_file(descriptor, begin, end, block_length)

    def read(begin: int, end: int, enter: int | None) -> Part:
        if enter is None:
            approach = max(begin - _APPROACH, 0)
            enter = _read(blocks(approach, begin), approach).leave
        if begin > 0:  # most likely in another process, where nobody is to be told
            return _read(blocks(begin, end), enter)
        # All parts are read at the same speed, so the share of the first stands for the file's.
        return _read(blocks(0, end), enter, lambda stop: tell(stop * size // end, size))

    gathered = Gathered()
    for part in read_parts(size, read):
        gathered.add(part.records)
    return gathered.records


def _read(blocks: Iterable[Block], enter: int, tell: Callable[[int], None] = lambda stop: None) -> Part:
    """The records of consecutive blocks."""
    gathered, leave, stop = Gathered(), enter, 0
    for block in blocks:
        records, leave = block.read(leave)
        gathered.add(records)
        stop = block.stop
        tell(stop)
    return Part(enter, leave, stop, gathered.records)

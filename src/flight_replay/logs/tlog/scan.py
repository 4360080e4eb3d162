"""Reads a log's records in memory that does not grow with it."""

from __future__ import annotations

from collections.abc import Callable

from flight_replay.logs.byte_source import OpenLog
from flight_replay.logs.tlog.blocks import read_blocks
from flight_replay.logs.tlog.columns import RecordBuffer, Records
from flight_replay.logs.tlog.records import read_records

BLOCK_LENGTH = 16 << 20


def scan(
    log: OpenLog, progress: Callable[[int, int], None] | None = None, block_length: int = BLOCK_LENGTH
) -> tuple[Records, int]:
    """All records of a log, and its length in bytes, unpacked.

    Args:
        log: The log.
        progress: Told the stored bytes read so far, and their number (0 where unknown).
        block_length: Bytes that are held at a time.
    """
    buffer, enter, length = RecordBuffer(), 0, 0
    for block in read_blocks(log.stream, block_length):
        records, enter = read_records(block, enter)
        buffer.add(records)
        length = block.offset + block.stop
        if progress:
            progress(log.position, log.size)
    return buffer.records, length

"""Reads the records of a binary DataFlash log, block by block, in memory that does not grow with it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from flight_replay.geometry.arrays import Bytes
from flight_replay.logs.byte_source import OpenLog, Progress
from flight_replay.logs.dataflash.message_rows import PackedRows
from flight_replay.logs.dataflash.record_formats import LONGEST_RECORD, FormatTable
from flight_replay.logs.dataflash.record_walk import FoundRecords, RecordWalk
from flight_replay.logs.tlog.byte_rows import rows_at

BLOCK_LENGTH = 1 << 20  # what is made of a block stays in the cache
_MARGIN = LONGEST_RECORD + 2  # bytes behind a block that tell whether its records are followed by a header


class RecordStream:
    """The records of some messages in a log.

    ``length`` counts the log's bytes so far, ``read_bytes`` those of records; ``restarts`` are the offsets
    at which logs begin that were joined to this one.
    """

    def __init__(
        self,
        log: OpenLog,
        names: Iterable[str],
        progress: Progress | None = None,
        block_length: int = BLOCK_LENGTH,
    ) -> None:
        self._log, self._progress, self._block_length = log, progress, block_length
        self.formats = FormatTable(names, log.name)
        self._walk = RecordWalk(self.formats)
        self.length = 0

    @property
    def read_bytes(self) -> int:
        """How many bytes belong to records."""
        return self._walk.read_bytes

    @property
    def restarts(self) -> list[int]:
        """Where FMT records define FMT itself."""
        return self._walk.restarts

    def blocks(self) -> Iterator[list[PackedRows]]:
        """The records of each block, message by message, in the order of the log within each.

        Raises:
            LogError: The log is no log of ArduPilot, or never stops changing its formats.
        """
        buffer = np.zeros(self._block_length + _MARGIN, np.uint8)
        filled = offset = 0
        while True:
            filled, is_last = self._fill(buffer, filled)
            data, stop = buffer[:filled], filled if is_last else self._block_length
            self.length = offset + filled
            found = self._walk.walk(data, offset, stop, is_last=is_last)
            yield [rows for part in found for rows in _messages(data, offset, part)]
            if self._progress:
                self._progress(self._log.position, self._log.size)
            if is_last:
                return
            self._walk.leave -= stop
            rest = data[stop:].copy()
            filled, offset = len(rest), offset + stop
            buffer[:filled] = rest

    def _fill(self, buffer: Bytes, filled: int) -> tuple[int, bool]:
        """Read on until the buffer is full: how many bytes it has then, and whether the log ends there."""
        while filled < len(buffer):
            got = self._log.stream.readinto(buffer[filled:].data)
            if not got:
                return filled, True
            filled += got
        return filled, False


def _messages(data: Bytes, offset: int, found: FoundRecords) -> Iterator[PackedRows]:
    """The records found in data that begins at an offset in the log, those of each type together."""
    counts = np.bincount(found.type)
    for kind in np.flatnonzero(counts).tolist():
        record = found.formats.get(kind)
        if record is None or record.dtype is None:
            continue
        starts = found.start if counts[kind] == len(found.start) else found.start[found.type == kind]
        rows = rows_at(data, starts, record.length).reshape(-1).view(record.dtype)
        yield PackedRows(starts + offset, record, rows)

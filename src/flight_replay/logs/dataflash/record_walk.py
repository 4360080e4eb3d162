"""Finds the records of a DataFlash log in its bytes, as a walk over every byte offset would.

The walk: a header (A3 95) of a known type counts as a record if another header, or the end of the log,
follows where its length ends; then the walk goes on there, else at the next header. So what looks like
a header inside a record is none, and a torn record, which has no checksum, is left out.

Here most of that is done at once: where each header is followed by the next one at its record's end,
there is nothing to decide. Only at breaks in this does the walk go step by step.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Bytes, Flags, Indices
from flight_replay.logs.dataflash.record_formats import (
    FMT_LENGTH,
    FMT_TYPE,
    HEADER,
    FormatTable,
    RecordFormat,
)

_SHORT_CHAIN, _PART = 4096, 128
_FEW = 256  # headers that are walked at first after a format changed: it may soon change again


@dataclass(frozen=True, slots=True, eq=False)
class FoundRecords:
    """Records of the wanted types: where they begin (n,), their types (n,), and the formats by type."""

    start: Indices
    type: Bytes
    formats: dict[int, RecordFormat]


class RecordWalk:
    """The walk through a log, block by block.

    ``leave`` is where in the last block's data the walk goes on; ``read_bytes`` counts those of records
    so far; ``restarts`` are the offsets of FMT records that define FMT itself, with which a log begins.
    """

    def __init__(self, formats: FormatTable) -> None:
        self.formats = formats
        self.leave = self.read_bytes = 0
        self.restarts: list[int] = []
        self._flags = np.zeros((2, 0), np.bool_)

    def walk(self, data: Bytes, offset: int, stop: int, *, is_last: bool = False) -> Iterator[FoundRecords]:
        """The records that begin in a block, which the walk enters at ``leave``.

        Args:
            data: The block's bytes, and as many behind it as the longest record and a header have.
            offset: Where in the log ``data`` begins.
            stop: Where in ``data`` the block ends.
            is_last: Whether the log ends where ``data`` does, and the block too.
        """
        starts = np.append(self._headers(data), len(data))
        at, last = (int(index) for index in np.searchsorted(starts[:-1], (self.leave, stop)))
        size = last
        while at < last:
            formats = self.formats.by_type
            reached = _Reached(data, starts, at, min(at + size, last), self.formats, is_last)
            changed = self._take_formats(data, offset, reached)
            if changed is None:
                at, size = reached.leave, 2 * size
            else:
                reached.cut(changed)
                at, size = int(np.searchsorted(starts, changed + FMT_LENGTH)), _FEW
            self.read_bytes += reached.length
            yield FoundRecords(reached.start, reached.type, formats)
        self.leave = int(starts[at]) if at > last else stop

    def _headers(self, data: Bytes) -> Indices:
        """Where headers may begin (n,)."""
        n = len(data) - 1
        if n < 2:
            return np.zeros(0, np.intp)
        if self._flags.shape[1] < n:
            self._flags = np.zeros((2, n), np.bool_)
        first, second = self._flags[:, :n]
        np.equal(data[:n], HEADER[0], out=first)
        np.equal(data[1:], HEADER[1], out=second)
        np.logical_and(first, second, out=first)
        return np.flatnonzero(first)

    def _take_formats(self, data: Bytes, offset: int, reached: _Reached) -> int | None:
        """Take the FMT records reached, up to the first that changes a format; where that begins."""
        for start in reached.start[reached.type == FMT_TYPE].tolist():
            fmt = data[start : start + FMT_LENGTH].tobytes()
            if fmt[3] == FMT_TYPE:
                self.restarts.append(offset + start)
            if self.formats.apply(fmt):
                return int(start)
        return None


class _Reached:
    """The records that the walk comes to from header ``first`` to before header ``last``.

    ``start`` and ``type`` (n,) are those of the wanted ones; ``leave`` is the number of the header at
    which the walk goes on: ``last``, or one behind it.
    """

    def __init__(  # noqa: PLR0913, PLR0917
        self, data: Bytes, starts: Indices, first: int, last: int, formats: FormatTable, is_last: bool
    ) -> None:
        self._starts = starts[first:last]
        types = data[2:].take(self._starts, mode="clip")
        self._lengths = formats.lengths.take(types)
        ends = self._starts + self._lengths
        is_wanted = formats.is_wanted.take(types).view(np.bool_)
        self.leave = last
        broken = np.flatnonzero(ends != starts[first + 1 : last + 1])
        if len(broken):
            follows = _has_header(data, ends[broken], is_last) & (self._lengths[broken] > 0)
            jumps = broken[follows]
            targets = _places_in(starts, ends[jumps], len(data)) - first
            is_record, target = _between_jumps(last - first, jumps, targets)
            is_record[broken[~follows]] = False
            self.leave = max(last, first + target)
            is_wanted &= is_record
            self._lengths *= is_record
        wanted = np.flatnonzero(is_wanted)
        self.start, self.type = self._starts.take(wanted), types.take(wanted)

    def cut(self, last_start: int) -> None:
        """Forget the records behind the one that begins there."""
        wanted = int(np.searchsorted(self.start, last_start, "right"))
        self.start, self.type = self.start[:wanted], self.type[:wanted]
        self._lengths = self._lengths[: np.searchsorted(self._starts, last_start, "right")]

    @property
    def length(self) -> int:
        """How many bytes the records have, those not wanted too."""
        return int(self._lengths.sum())


def _has_header(data: Bytes, places: Indices, is_last: bool) -> Flags:
    """Whether a header, or the end of the log, is at places (n,)."""
    inside = np.minimum(places, len(data) - 2)
    found = (data[inside] == HEADER[0]) & (data[inside + 1] == HEADER[1]) & (places == inside)
    return np.asarray(found | (places == len(data)) if is_last else found)


def _between_jumps(n: int, jumps: Indices, targets: Indices) -> tuple[Flags, int]:
    """Which of ``n`` headers a walk comes to, and the last header that it jumps to.

    The walk goes from each header to the next, but from those of ``jumps`` (m,) to ``targets`` (m,),
    which may be behind the last.
    """
    taken = _chain(_places_in(jumps, np.minimum(targets, n), n))
    if not len(taken):
        return np.ones(n, np.bool_), 0
    steps = np.zeros(n + 1, np.int8)
    steps[jumps[taken] + 1] += 1
    steps[np.minimum(targets[taken], n)] -= 1
    return np.cumsum(steps[:-1], dtype=np.int8) == 0, int(targets[taken[-1]])


def _places_in(ascending: Indices, wanted: Indices, most: int) -> Indices:
    """What ``searchsorted`` gives for values up to ``most``, faster where many are wanted."""
    if len(wanted) <= _SHORT_CHAIN:
        return np.searchsorted(ascending, wanted)
    below = np.zeros(most + 2, np.intp)
    below[ascending + 1] = 1
    return np.cumsum(below)[wanted]


def _chain(following: Indices) -> Indices:
    """The indices that one comes to from 0, from each to the ``following`` one (m,), until that is none.

    Each follows one before it. A long chain, which no ordinary log has, is cut in parts that are walked
    side by side: first to find where one leaves each part from each index, then which indices are met.
    """
    m = len(following)
    if m <= _SHORT_CHAIN:
        return _walked(following)
    part = np.full((-(-m // _PART), _PART), m, np.intp)
    part.reshape(-1)[:m] = following
    first = np.arange(len(part)) * _PART
    leave, local = part.copy(), part - first[:, None]
    for column in reversed(range(_PART)):
        stays = np.flatnonzero(local[:, column] < _PART)
        leave[stays, column] = leave[stays, local[stays, column]]
    is_met = np.zeros(part.shape, np.bool_)
    is_met.reshape(-1)[_walked(leave.reshape(-1)[:m])] = True
    for column in range(_PART):
        stays = np.flatnonzero(is_met[:, column] & (local[:, column] < _PART))
        is_met[stays, local[stays, column]] = True
    return np.flatnonzero(is_met.reshape(-1)[:m])


def _walked(following: Indices) -> Indices:
    """As ``_chain``, step by step."""
    steps, at, taken = following.tolist(), 0, []
    while at < len(steps):
        taken.append(at)
        at = steps[at]
    return np.array(taken, np.intp)

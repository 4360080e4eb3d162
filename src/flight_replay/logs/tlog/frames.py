"""What may be MAVLink frames in bytes: all start marks at once, and what their headers say.

The walk over every byte offset (``walk.py``) needs only two things of them: the frames of the
few messages that are read, and those frames that another one may begin in.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Bytes, Indices
from flight_replay.logs.tlog import message_table
from flight_replay.logs.tlog.crc import rows_at

SLICE_LENGTH = 1 << 20  # bytes of which all that is made stays in a core's cache
STAMP_LENGTH = 8
ROW_LENGTH = STAMP_LENGTH + 40  # a stamp, either version's header, and 28 bytes of payload or more
_NO_MESSAGE = 255  # an id that nobody wants
_NOWHERE: Indices = np.zeros(0, np.intp)
_NO_ROWS: Bytes = np.zeros((0, ROW_LENGTH), np.uint8)


@dataclass(frozen=True, slots=True)
class Span:
    """Bytes from ``start`` to ``stop``; the data ends at ``end``, what is behind are no bytes of the log."""

    start: int
    stop: int
    end: int


class Window:
    """Bytes of a log being looked at, with room to mark some of them; used again for the next bytes."""

    def __init__(self, length: int) -> None:
        self.data: Bytes = np.zeros(length, np.uint8)
        self._marks: Bytes = np.empty(SLICE_LENGTH, np.uint8)

    def marks(self, start: int, stop: int) -> Indices:
        """Where the start marks in [start, stop) are, counted from ``start``; of no more than a slice."""
        marks = self._marks[: stop - start]
        # The two marks are neighbours, so one subtraction and one comparison in place find both.
        np.subtract(self.data[start:stop], message_table.MAVLINK2_MARK, out=marks)
        others = message_table.MAVLINK1_MARK - message_table.MAVLINK2_MARK
        return np.flatnonzero(np.less_equal(marks, others, out=marks.view(np.bool_)))


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """What may be frames of one message, in ascending order.

    ``start`` is where, shape (n,); ``rows`` are the bytes from the stamp before it on, shape
    (n, ROW_LENGTH), kept because looking them up again would take longest of all.
    """

    start: Indices
    rows: Bytes

    def take(self, index: Indices) -> Candidates:
        """Those of an index array."""
        return Candidates(self.start.take(index), self.rows.take(index, axis=0))


@dataclass(frozen=True, slots=True, eq=False)
class Reaching:
    """Frames, right or not, that reach over where others begin: where they do and end, (n,), ascending."""

    start: Indices
    end: Indices


@dataclass(frozen=True, slots=True, eq=False)
class Marked:
    """Bytes, what may be frames of each wanted message in them, and all frames ``reaching`` over others."""

    data: Bytes
    wanted: Mapping[int, Candidates]
    reaching: Reaching


def mark(window: Window, slices: Iterable[Span], wanted: Sequence[int]) -> Marked:
    """Find all that may be frames of the ``wanted`` messages, by id, and all that may hide one.

    ``slices`` follow each other, each of ``SLICE_LENGTH`` at most.
    """
    candidates: dict[int, list[Candidates]] = {message: [] for message in wanted}
    reaching = []
    for span in slices:
        headers = _headers(window, span)
        for message, found in headers.candidates(window.data, wanted):
            candidates[message].append(found)
        reaching.append(headers.reaching(span.stop))
    joined = {message: _joined_candidates(found) for message, found in candidates.items()}
    return Marked(window.data, joined, _joined_reaching(reaching))


@dataclass(frozen=True, slots=True, eq=False)
class _Headers:
    """Start marks of a slice, counted from its ``base``, and what the headers there say, shape (n,).

    ``message`` is an id of one byte, ``length`` that of the whole frame, 0 where there can be none.
    """

    base: int
    start: Indices
    message: NDArray[np.uint8]
    length: NDArray[np.int16]

    def candidates(self, data: Bytes, wanted: Sequence[int]) -> Iterator[tuple[int, Candidates]]:
        """What may be frames of each wanted message."""
        is_wanted = self.message == wanted[0]
        for message in wanted[1:]:
            is_wanted |= self.message == message
        is_wanted &= self.length > 0
        index = np.flatnonzero(is_wanted)
        start, messages_of = self.start.take(index) + self.base, self.message.take(index)
        for message in wanted:
            its = start.take(np.flatnonzero(messages_of == message))
            yield message, Candidates(its, rows_at(data, its - STAMP_LENGTH, ROW_LENGTH))

    def reaching(self, stop: int) -> Reaching:
        """What reaches over the start of another frame, or of two marks of any kind, or over ``stop``."""
        start = self.start.astype(np.int32)
        end = start + self.length
        over = end > stop - self.base
        over[:-1] |= (end[:-1] > start[1:]) & (self.length[1:] > 0)
        over[:-2] |= end[:-2] > start[2:]
        index = np.flatnonzero(over)
        return Reaching(self.start.take(index) + self.base, end.take(index) + np.intp(self.base))


def _headers(window: Window, span: Span) -> _Headers:
    """All start marks of a slice."""
    data = window.data[span.start :]
    start = window.marks(span.start, span.stop)
    message = data[5:].take(start)
    payload = data[1:].take(start)
    shape = message.astype(np.uint16)
    shape <<= 8
    shape |= payload
    length = payload.astype(np.int16)
    length += message_table.MAVLINK1_OVERHEAD
    length *= message_table.MAVLINK1_SHAPES.take(shape)
    mavlink2 = np.flatnonzero(data.take(start) == message_table.MAVLINK2_MARK)
    length[mavlink2] = 0
    places = start.take(mavlink2)
    readable = np.flatnonzero(data[2:].take(places) <= message_table.SIGNED)
    mavlink2 = mavlink2.take(readable)
    length[mavlink2], message[mavlink2] = _mavlink2_headers(data, places.take(readable))
    if span.stop + message_table.LONGEST_FRAME > span.end:
        length[start + length > span.end - span.start] = 0
    return _Headers(span.start, start, message, length)


def _mavlink2_headers(data: Bytes, places: Indices) -> tuple[NDArray[np.int16], NDArray[np.uint8]]:
    """Frame lengths (n,), 0 where there can be no frame, and message ids where they fit one byte.

    Incompatibility flags are those of a signature at most: a frame that has others must not be
    read (mavlink.io, "Incompatibility Flags").
    """
    payload, flags, low, mid, high = (data[at:].take(places) for at in (1, 2, 7, 8, 9))
    possible = (message_table.EXTRAS.take(mid.astype(np.uint16) << 8 | low) >= 0) & (high == 0)
    length = (
        flags * np.int16(message_table.SIGNATURE_LENGTH) + payload + np.int16(message_table.MAVLINK2_OVERHEAD)
    )
    return length * possible, np.where(mid > 0, np.uint8(_NO_MESSAGE), low)


def _joined_candidates(parts: list[Candidates]) -> Candidates:
    """The candidates of consecutive slices."""
    start = np.concatenate([_NOWHERE, *(part.start for part in parts)])
    return Candidates(start, np.concatenate([_NO_ROWS, *(part.rows for part in parts)]))


def _joined_reaching(parts: list[Reaching]) -> Reaching:
    """What reaches over others in consecutive slices."""
    start = np.concatenate([_NOWHERE, *(part.start for part in parts)])
    return Reaching(start, np.concatenate([_NOWHERE, *(part.end for part in parts)]))

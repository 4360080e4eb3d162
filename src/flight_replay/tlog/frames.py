"""Finds MAVLink frames in bytes, as a walk over every byte offset would.

The walk: at each offset, a frame whose header, length and CRC are right is a record and is
skipped whole; anything else is skipped by one byte. So a frame inside another frame's payload
is no record. Here the same is found without walking: all start marks at once, and then only
those wanted frames that another one could hide are looked at closely (``hidden.py``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.tlog import messages
from flight_replay.tlog.crc import Bytes, Flags, Index, are_right
from flight_replay.tlog.hidden import find_hidden, header_length, is_right_at

_NO_MESSAGE = 255  # an id that no message has
_NEAR = 3
_FEW, _MANY = 8, 100  # from how many frames on columns are worth their overhead


@dataclass(frozen=True, slots=True)
class Span:
    """Bytes from ``start`` to ``stop``; the data ends at ``end``, what is behind are no bytes of the log."""

    start: int
    stop: int
    end: int


class Window:
    """Bytes of a log being looked at, with room to mark them; used again for the next bytes."""

    def __init__(self, length: int) -> None:
        self.data: Bytes = np.zeros(length, np.uint8)
        self._marks: Bytes = np.empty(length, np.uint8)

    def marks(self, start: int, stop: int) -> Index:
        """Where the start marks in [start, stop) are."""
        marks = self._marks[start:stop]
        np.subtract(self.data[start:stop], messages.MAVLINK2_MARK, out=marks)
        others = messages.MAVLINK1_MARK - messages.MAVLINK2_MARK
        places = np.flatnonzero(np.less_equal(marks, others, out=marks.view(np.bool_)))
        places += start
        return places


@dataclass(frozen=True, slots=True, eq=False)
class Marked:
    """A span with its start marks and the frames that they would begin, in order, every column (n,).

    ``end`` is behind the frame, or ``start`` where the header is that of no frame; ``message`` is
    the id, or 255 where that takes more than a byte. ``wanted`` (m,) are the indices of frames of
    wanted messages.
    """

    data: Bytes
    span: Span
    start: Index
    end: Index
    message: NDArray[np.uint8]
    is_mavlink1: Flags
    wanted: Index


def mark(window: Window, span: Span, wanted: Flags) -> Marked:
    """Find all that may be frames in a span, and those whose message is ``wanted``, by id (256,)."""
    data = window.data
    start = window.marks(span.start, span.stop)
    message = data[5:].take(start)
    length = messages.MAVLINK1_FRAME_LENGTHS.take(message.astype(np.uint16) << 8 | data[1:].take(start))
    is_mavlink1 = data.take(start) == messages.MAVLINK1_MARK
    mavlink2 = np.flatnonzero(~is_mavlink1)
    length[mavlink2] = 0
    mavlink2 = mavlink2[data[2:].take(start.take(mavlink2)) <= messages.SIGNED]
    length[mavlink2], message[mavlink2] = _mavlink2_headers(data, start.take(mavlink2))
    end = start + length
    if span.stop + messages.LONGEST_FRAME > span.end:
        np.copyto(end, start, where=end > span.end)
    return Marked(data, span, start, end, message, is_mavlink1, np.flatnonzero(wanted.take(message)))


class Walk:
    """The walk over a marked span, beginning at ``enter``; frames go by their index (m,) in the span."""

    def __init__(self, marked: Marked, enter: int) -> None:
        self.marked = marked
        self._entered = int(np.searchsorted(marked.start, enter))
        self._wanted = marked.wanted[np.searchsorted(marked.wanted, self._entered) :]
        self._messages = marked.message.take(self._wanted)
        self._stop = max(marked.span.stop, enter)

    def candidates(self, message: int) -> Index:
        """What may be records of a wanted message."""
        index = self._wanted.take(np.flatnonzero(self._messages == message))
        complete = np.flatnonzero(self.marked.end.take(index) > self.marked.start.take(index))
        return np.asarray(index.take(complete))

    def finds(self, index: Index) -> Flags:
        """Whether the walk comes to each of the candidates and finds its CRC right."""
        right = _are_right(self.marked, index)
        doubtful = right if len(right) <= _MANY else right & self._may_be_hidden(index)
        suspects = self.marked.start[index[doubtful]].tolist()
        hidden = self._hidden(suspects)[0] if suspects else None
        if hidden:
            right &= ~np.isin(self.marked.start.take(index), list(hidden))
        return right

    @property
    def leave(self) -> int:
        """Where the walk goes on: behind the span, or behind the record that reaches over its end."""
        return self._hidden([])[1]

    def _hidden(self, suspects: list[int]) -> tuple[set[int], int]:
        starts, ends = self.marked.start[self._entered :], self.marked.end[self._entered :]
        return find_hidden(self.marked.data, starts, ends, suspects, self._stop)

    def _may_be_hidden(self, index: Index) -> Flags:
        """Which frames another one may reach over that begins before: sure only where it says no.

        The nearest neighbours are asked directly, which is all there is to ask in a tidy log; those
        that reach over more marks than that are few.
        """
        start, end = self.marked.start, self.marked.end
        places = start.take(index)
        reached = np.zeros(len(index), np.bool_)
        for back in range(1, _NEAR + 1):
            reached |= end.take(np.maximum(index - back, 0)) > places
        far = np.flatnonzero(end[: -_NEAR - 1] > start[_NEAR + 1 :])
        firsts = np.searchsorted(index, far, "right")
        lasts = np.searchsorted(places, end.take(far))
        over = np.bincount(firsts, minlength=len(index) + 1) - np.bincount(lasts, minlength=len(index) + 1)
        return np.asarray(reached | (np.cumsum(over[:-1]) > 0))


def _mavlink2_headers(data: Bytes, places: Index) -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
    """Frame lengths (n,), 0 where there can be no frame, and message ids where they fit one byte.

    A frame with incompatibility flags other than that of a signature must not be read
    (mavlink.io, "Incompatibility Flags"), so none of those is asked about.
    """
    payload, flags, low, mid, high = (data[at:].take(places) for at in (1, 2, 7, 8, 9))
    known = (messages.EXTRAS.take(mid.astype(np.uint16) << 8 | low) >= 0) & (high == 0)
    length = payload + flags * np.int32(messages.SIGNATURE_LENGTH) + messages.MAVLINK2_OVERHEAD
    return np.where(known, length, 0), np.where(mid > 0, np.uint8(_NO_MESSAGE), low)


def _are_right(marked: Marked, index: Index) -> Flags:
    """Whether the CRC of each frame (m,) is right; all are of messages whose id fits one byte.

    Frames of the same message, version and length are checked together. Where there are few of
    them they are most likely none, and not worth columns.
    """
    right = np.zeros(len(index), np.bool_)
    start, message = marked.start.take(index), marked.message.take(index)
    shape = (
        marked.data[1:].take(start).astype(np.uint16) | marked.is_mavlink1.take(index).astype(np.uint16) << 8
    )
    for each in np.flatnonzero(np.bincount(message)).tolist():
        members = np.flatnonzero(message == each)
        shapes = shape.take(members)
        counts = np.bincount(shapes, minlength=1)
        few = members[counts.take(shapes) <= _FEW]
        right[few] = [is_right_at(marked.data, place) for place in start.take(few).tolist()]
        for common in np.flatnonzero(counts > _FEW).tolist():
            alike = members[shapes == common]
            length = header_length(common >> 8 == 1) + common % 256
            right[alike] = are_right(marked.data, start.take(alike), length, int(messages.EXTRAS[each]))
    return right

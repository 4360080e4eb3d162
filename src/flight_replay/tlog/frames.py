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
_FEW = 8


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
class Frames:
    """Frames in the order of their start marks, every column of shape (n,).

    ``end`` is behind the frame, or ``start`` where the header is that of no frame; ``message`` is
    the id, or 255 where that takes more than a byte.
    """

    start: Index
    end: Index
    message: NDArray[np.uint8]
    is_mavlink1: Flags

    def __len__(self) -> int:
        return len(self.start)

    def select(self, keep: Flags | Index) -> Frames:
        """The frames that a mask or an index array picks."""
        return Frames(self.start[keep], self.end[keep], self.message[keep], self.is_mavlink1[keep])


@dataclass(frozen=True, slots=True, eq=False)
class Marked:
    """A span with its start marks, as the frames that they would begin; ``index`` tells the wanted ones."""

    window: Window
    span: Span
    candidates: Frames
    index: Index


def mark(window: Window, span: Span, wanted: Flags) -> Marked:
    """Find all that may be frames in a span, and those whose message is ``wanted``, by id (256,)."""
    places = window.marks(span.start, span.stop)
    data = window.data
    message = data[5:].take(places)
    length = messages.MAVLINK1_FRAME_LENGTHS.take(message.astype(np.uint16) << 8 | data[1:].take(places))
    is_mavlink1 = data.take(places) == messages.MAVLINK1_MARK
    mavlink2 = np.flatnonzero(~is_mavlink1)
    length[mavlink2] = 0
    mavlink2 = mavlink2[data[2:].take(places.take(mavlink2)) <= messages.SIGNED]
    length[mavlink2], message[mavlink2] = _mavlink2_headers(data, places.take(mavlink2))
    ends = places + length
    if span.stop + messages.LONGEST_FRAME > span.end:
        np.copyto(ends, places, where=ends > span.end)
    index = np.flatnonzero(wanted.take(message))
    return Marked(window, span, Frames(places, ends, message, is_mavlink1), index)


class Walk:
    """The walk over a marked span, beginning at ``enter``."""

    def __init__(self, marked: Marked, enter: int) -> None:
        self.data = marked.window.data
        self._starts = marked.candidates.start
        self._ends = marked.candidates.end
        self._entered = int(np.searchsorted(self._starts, enter))
        index = marked.index[np.searchsorted(marked.index, self._entered) :]
        self._wanted = marked.candidates.select(index)
        self._stop = max(marked.span.stop, enter)

    def candidates(self, message: int) -> Frames:
        """What may be records of a wanted message."""
        return self._wanted.select(
            np.flatnonzero((self._wanted.message == message) & (self._wanted.end > self._wanted.start))
        )

    def finds(self, frames: Frames) -> Flags:
        """Whether the walk comes to each of the candidates (n,) and finds its CRC right."""
        right = _are_right(self.data, frames)
        suspects = frames.start[right & self._may_be_hidden(frames.start)].tolist()
        if suspects:
            hidden, _ = self._hidden(suspects)
            right &= ~np.isin(frames.start, list(hidden))
        return right

    @property
    def leave(self) -> int:
        """Where the walk goes on: behind the span, or behind the record that reaches over its end."""
        return self._hidden([])[1]

    def _hidden(self, suspects: list[int]) -> tuple[set[int], int]:
        starts, ends = self._starts[self._entered :], self._ends[self._entered :]
        return find_hidden(self.data, starts, ends, suspects, self._stop)

    def _may_be_hidden(self, places: Index) -> Flags:
        """Which start marks (m,) a frame may reach over that begins before: sure only where it says no.

        The nearest neighbours are asked directly, which is all there is to ask in a tidy log; those
        that reach over more marks than that are few.
        """
        starts, ends = self._starts, self._ends
        index = np.searchsorted(starts, places)
        reached = np.zeros(len(index), np.bool_)
        for back in range(1, _NEAR + 1):
            reached |= ends.take(np.maximum(index - back, 0)) > places
        far = np.flatnonzero(ends[: -_NEAR - 1] > starts[_NEAR + 1 :])
        firsts = np.searchsorted(places, starts.take(far), "right")
        lasts = np.searchsorted(places, ends.take(far))
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


def _are_right(data: Bytes, frames: Frames) -> Flags:
    """Whether the CRC of each frame (n,) is right; all ids fit one byte.

    Frames of the same message, version and length are checked together. Where there are few of
    them they are most likely none, and not worth columns.
    """
    right = np.zeros(len(frames.start), np.bool_)
    shape = data[1:].take(frames.start).astype(np.uint16) | frames.is_mavlink1.astype(np.uint16) << 8
    for message in np.flatnonzero(np.bincount(frames.message)).tolist():
        members = np.flatnonzero(frames.message == message)
        shapes = shape.take(members)
        counts = np.bincount(shapes, minlength=1)
        few = members[counts.take(shapes) <= _FEW]
        right[few] = [is_right_at(data, start) for start in frames.start.take(few).tolist()]
        for each in np.flatnonzero(counts > _FEW).tolist():
            alike = members[shapes == each]
            length = header_length(each >> 8 == 1) + each % 256
            right[alike] = are_right(data, frames.start.take(alike), length, int(messages.EXTRAS[message]))
    return right

"""Finds MAVLink frames in bytes, as a walk over every byte offset would.

The walk: at each offset, a frame whose header, length and CRC are right is a record and is
skipped whole; anything else is skipped by one byte. So a frame inside another frame's payload
is no record. Here the same is found without walking: all start marks at once, and then only
those wanted frames that another one could hide are looked at closely (``hidden.py``).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.tlog import messages
from flight_replay.tlog.crc import Bytes, Flags, Index, are_right
from flight_replay.tlog.hidden import find_hidden, header_length, is_right_at

_NO_MESSAGE = 255  # an id that no message has
_FEW = 8  # frames that are not worth columns
SLICE_LENGTH = 1 << 20  # bytes of which all that is made stays in a core's cache


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

    def marks(self, start: int, stop: int) -> Index:
        """Where the start marks in [start, stop) are, of no more bytes than a slice."""
        marks = self._marks[: stop - start]
        np.subtract(self.data[start:stop], messages.MAVLINK2_MARK, out=marks)
        others = messages.MAVLINK1_MARK - messages.MAVLINK2_MARK
        places = np.flatnonzero(np.less_equal(marks, others, out=marks.view(np.bool_)))
        places += start
        return places


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """Start marks in ascending order and the frames that they would begin, every column of shape (n,).

    ``end`` is behind the frame, or ``start`` where the header is that of no frame; ``message`` is
    the id, or 255 where that takes more than a byte.
    """

    start: Index
    end: Index
    message: NDArray[np.uint8]
    is_mavlink1: Flags

    def take(self, index: Index) -> Frames:
        """The frames of an index array."""
        start, end = self.start.take(index), self.end.take(index)
        return Frames(start, end, self.message.take(index), self.is_mavlink1.take(index))

    def since(self, place: int) -> Frames:
        """The frames that begin at ``place`` or later."""
        first = np.searchsorted(self.start, place)
        return Frames(self.start[first:], self.end[first:], self.message[first:], self.is_mavlink1[first:])


@dataclass(frozen=True, slots=True, eq=False)
class Marked:
    """What may be frames of ``wanted`` messages, and all frames ``reaching`` over the start of another."""

    data: Bytes
    wanted: Frames
    reaching: Frames


def mark(window: Window, slices: Iterable[Span], wanted: Flags) -> Marked:
    """Find all that may be frames, and those whose message is ``wanted``, by id (256,).

    ``slices`` follow each other, each of ``SLICE_LENGTH`` at most.
    """
    found, reaching = [], []
    for span in slices:
        frames = _candidates(window, span)
        is_frame = frames.end > frames.start
        found.append(frames.take(np.flatnonzero(wanted.take(frames.message) & is_frame)))
        reaching.append(frames.take(_reaching(frames, is_frame, span.stop)))
    return Marked(window.data, _joined(found), _joined(reaching))


def _reaching(frames: Frames, is_frame: Flags, stop: int) -> Index:
    """Which frames reach over the start of another, or of two marks whatever these are, or over ``stop``."""
    start, end = frames.start, frames.end
    over = end > stop
    over[:-1] |= is_frame[1:] & (end[:-1] > start[1:])
    over[:-2] |= end[:-2] > start[2:]
    return np.flatnonzero(over)


def _candidates(window: Window, span: Span) -> Frames:
    """All start marks of a slice."""
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
    return Frames(start, end, message, is_mavlink1)


def _joined(parts: list[Frames]) -> Frames:
    """The frames of consecutive slices."""
    if not parts:
        nowhere = np.zeros(0, np.intp)
        return Frames(nowhere, nowhere, nowhere.astype(np.uint8), nowhere.astype(np.bool_))
    return Frames(
        np.concatenate([part.start for part in parts]),
        np.concatenate([part.end for part in parts]),
        np.concatenate([part.message for part in parts]),
        np.concatenate([part.is_mavlink1 for part in parts]),
    )


class Walk:
    """The walk over marked bytes: it comes to ``enter``, and ends at ``stop`` or behind."""

    def __init__(self, marked: Marked, enter: int, stop: int) -> None:
        self.data = marked.data
        self._stop = max(stop, enter)
        self._wanted = marked.wanted.since(enter)
        self._reaching = marked.reaching.since(enter)
        self._reach = np.maximum.accumulate(np.append(np.intp(0), self._reaching.end))

    def candidates(self, message: int) -> Frames:
        """What may be records of a wanted message."""
        return self._wanted.take(np.flatnonzero(self._wanted.message == message))

    def finds(self, frames: Frames, message: int) -> Flags:
        """Whether the walk comes to each of a message's candidates (n,) and finds its CRC right."""
        right = _are_right(self.data, frames, int(messages.EXTRAS[message]))
        reached = self._reach.take(np.searchsorted(self._reaching.start, frames.start)) > frames.start
        suspects = frames.start[right & reached].tolist()
        hidden = self._hidden(suspects)[0] if suspects else None
        if hidden:
            right &= ~np.isin(frames.start, list(hidden))
        return right

    @property
    def leave(self) -> int:
        """Where the walk goes on: where it was to stop, or behind the record that reaches over that."""
        return self._hidden([])[1]

    def _hidden(self, suspects: list[int]) -> tuple[set[int], int]:
        return find_hidden(self.data, self._reaching.start, self._reaching.end, suspects, self._stop)


def _mavlink2_headers(data: Bytes, places: Index) -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
    """Frame lengths (n,), 0 where there can be no frame, and message ids where they fit one byte.

    A frame with incompatibility flags other than that of a signature must not be read
    (mavlink.io, "Incompatibility Flags"), so none of those is asked about.
    """
    payload, flags, low, mid, high = (data[at:].take(places) for at in (1, 2, 7, 8, 9))
    known = (messages.EXTRAS.take(mid.astype(np.uint16) << 8 | low) >= 0) & (high == 0)
    length = flags.astype(np.int32) * messages.SIGNATURE_LENGTH + payload + messages.MAVLINK2_OVERHEAD
    return np.where(known, length, 0), np.where(mid > 0, np.uint8(_NO_MESSAGE), low)


def _are_right(data: Bytes, frames: Frames, extra: int) -> Flags:
    """Whether the CRC of each of a message's frames (n,) is right.

    Frames of the same version and length are checked together, but where there are few of them,
    which are most likely none.
    """
    right = np.zeros(len(frames.start), np.bool_)
    shape = data[1:].take(frames.start).astype(np.intp)
    shape[frames.is_mavlink1] += 256
    counts = np.bincount(shape, minlength=1)
    few = np.flatnonzero((counts <= _FEW).take(shape))
    right[few] = [is_right_at(data, place) for place in frames.start.take(few).tolist()]
    for common in np.flatnonzero(counts > _FEW).tolist():
        alike = np.flatnonzero(shape == common)
        length = header_length(common >= 256) + common % 256
        right[alike] = are_right(data, frames.start.take(alike), length, extra)
    return right

"""Finds MAVLink frames in bytes, as a walk over every byte offset would.

The walk: at each offset, a frame whose header, length and CRC are right is a record and is
skipped whole; anything else is skipped by one byte. So a frame inside another frame's payload
is no record. Here the same is found without walking: all start marks at once, and then only
those frames that could hide another one are looked at closely.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.tlog import messages
from flight_replay.tlog.crc import Bytes, Flags, Index, are_right, is_right

_MAVLINK2_MARK, _MAVLINK1_MARK = 0xFD, 0xFE
_NO_MESSAGE = 255  # an id that no message has
_SIGNED = 1  # the one incompatibility flag there is
_FEW = 8


class Window:
    """Bytes of a log being looked at, with room to mark them; used again for the next bytes."""

    def __init__(self, length: int) -> None:
        self.data: Bytes = np.zeros(length, np.uint8)
        self._marks: Bytes = np.empty(length, np.uint8)
        self._is_mark = np.empty(length, np.bool_)

    def marks(self, start: int, stop: int) -> tuple[Index, Flags]:
        """Where the start marks in [start, stop) are, counted from ``start``, and which are MAVLink 1's."""
        marks, is_mark = self._marks[start:stop], self._is_mark[start:stop]
        np.subtract(self.data[start:stop], _MAVLINK2_MARK, out=marks)
        np.less_equal(marks, _MAVLINK1_MARK - _MAVLINK2_MARK, out=is_mark)
        places = np.flatnonzero(is_mark)
        return places, marks.take(places).view(np.bool_)


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """Start marks in ascending order, every column of shape (n,).

    ``end`` is where the frame would end, or ``start`` where the header is that of no frame;
    ``message`` is the id, or 255 where it takes more than one byte.
    """

    start: Index
    end: Index
    message: NDArray[np.uint8]
    is_mavlink1: Flags

    def select(self, keep: Index | Flags) -> Candidates:
        """The candidates that a mask or an index array picks."""
        return Candidates(self.start[keep], self.end[keep], self.message[keep], self.is_mavlink1[keep])


def find_records(
    window: Window, start: int, stop: int, end: int, wanted: NDArray[np.uint8]
) -> tuple[Candidates, int]:
    """The wanted records that start in [start, stop), and where the walk goes on, at ``stop`` or later.

    Args:
        window: Bytes; ``LONGEST_FRAME`` of them from ``stop`` on can be read.
        start: Where the walk comes to.
        stop: Where it ends.
        end: Where the data ends; what is behind are no bytes of the log.
        wanted: Ids of messages, all below 255.
    """
    candidates = find_candidates(window, start, stop, end)
    found = np.flatnonzero(np.isin(np.arange(256), wanted).take(candidates.message))
    frames = candidates.select(found)
    may_be_hidden = frames.start < _latest_end_before(candidates, found)
    right = _are_right(window.data, frames)
    suspects = [*frames.start[may_be_hidden & right].tolist(), stop]
    hidden, resume = _hidden(window.data, candidates, suspects, stop)
    if hidden:
        right &= ~np.isin(frames.start, hidden)
    return frames if right.all() else frames.select(right), resume


def find_candidates(window: Window, start: int, stop: int, end: int) -> Candidates:
    """All start marks in [start, stop), with the frame that each would begin."""
    places, is_mavlink1 = window.marks(start, stop)
    data = window.data[start:]
    message = data[5:].take(places)
    length = messages.MAVLINK1_FRAME_LENGTHS.take(message.astype(np.uint16) << 8 | data[1:].take(places))
    mavlink2 = np.flatnonzero(~is_mavlink1)
    length[mavlink2] = 0
    mavlink2 = mavlink2[data[2:].take(places.take(mavlink2)) <= _SIGNED]
    length[mavlink2], message[mavlink2] = _mavlink2_headers(data, places.take(mavlink2))
    places += start
    ends = places + length
    if stop + messages.LONGEST_FRAME > end:
        np.copyto(ends, places, where=ends > end)
    return Candidates(places, ends, message, is_mavlink1)


def _mavlink2_headers(data: Bytes, places: Index) -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
    """Frame lengths (n,), 0 where there can be no frame, and message ids where they fit one byte.

    A frame with incompatibility flags other than that of a signature must not be read
    (mavlink.io, "Incompatibility Flags"), so none of those is asked about.
    """
    payload, flags, low, mid, high = (data[at:].take(places) for at in (1, 2, 7, 8, 9))
    known = (messages.EXTRAS.take(mid.astype(np.uint16) << 8 | low) >= 0) & (high == 0)
    length = payload + flags * np.int32(messages.SIGNATURE_LENGTH) + messages.MAVLINK2_OVERHEAD
    return np.where(known, length, 0), np.where(mid > 0, np.uint8(_NO_MESSAGE), low)


def _latest_end_before(candidates: Candidates, index: Index) -> Index:
    """How far the candidates before each index (m,) reach at most; 0 where there is none before."""
    if not len(index):
        return index
    first = candidates.end[: index[0]].max(initial=0)
    between = np.maximum.reduceat(candidates.end, index)
    return np.maximum.accumulate(np.concatenate([[first], between[:-1]]))


def _header_length(mavlink1: bool) -> int:
    """Bytes between the start mark and the payload."""
    return 5 if mavlink1 else 9


def _are_right(data: Bytes, frames: Candidates) -> Flags:
    """Whether the CRC of each frame (n,) is right; all ids fit one byte."""
    right = np.zeros(len(frames.start), np.bool_)
    complete = frames.end > frames.start
    shape = data[1:].take(frames.start).astype(np.uint16) | frames.is_mavlink1.astype(np.uint16) << 8
    for message in np.flatnonzero(np.bincount(frames.message)).tolist():
        of_message = np.flatnonzero((frames.message == message) & complete)
        shapes = shape.take(of_message)
        for each in np.flatnonzero(np.bincount(shapes)).tolist():
            members = of_message[shapes == each]
            starts = frames.start.take(members)
            if len(members) <= _FEW:  # most of these are no frames at all, and not worth columns
                right[members] = [_is_right(data, start) for start in starts.tolist()]
            else:
                length = _header_length(each >> 8 == 1) + each % 256
                right[members] = are_right(data, starts, length, int(messages.EXTRAS[message]))
    return right


def _hidden(data: Bytes, candidates: Candidates, suspects: list[int], stop: int) -> tuple[list[int], int]:
    """Which of the suspects the walk never comes to, and where it goes on from ``stop``.

    ``suspects`` are starts of right frames, and ``stop``. What can hide one is a right frame that
    begins before it and ends behind it, and what can hide that, and so on; a walk over all of
    these alone visits the same of them as the walk over every byte.
    """
    spanning: dict[int, int] = {}
    frontier = suspects
    while frontier:
        fresh = dict(_spanning(candidates, frontier)).items() - spanning.items()
        right = {start: end for start, end in fresh if _is_right(data, start)}
        spanning |= right
        frontier = list(right)
    hidden, resume = [], 0
    for place in sorted({*suspects, *spanning} - {stop}) if spanning else []:
        if place < resume:
            hidden.append(place)
        else:
            resume = spanning.get(place, 0)
    return hidden, max(resume, stop)


def _spanning(candidates: Candidates, places: list[int]) -> Iterator[tuple[int, int]]:
    """Start and end of each candidate that begins before and ends behind one of the places."""
    lasts = np.searchsorted(candidates.start, places)
    firsts = np.searchsorted(candidates.start, np.array(places) - messages.LONGEST_FRAME)
    for place, first, last in zip(places, firsts.tolist(), lasts.tolist(), strict=True):
        for index, end in enumerate(candidates.end[first:last].tolist(), first):
            if end > place:
                yield int(candidates.start[index]), end


def _is_right(data: Bytes, start: int) -> bool:
    """Whether the CRC of the frame that begins at ``start`` is right, whichever message it is."""
    mavlink1 = bool(data[start] == _MAVLINK1_MARK)
    header = data[start + 5 : start + 6] if mavlink1 else data[start + 7 : start + 9]
    message = int.from_bytes(header.tobytes(), "little")
    length = _header_length(mavlink1) + int(data[start + 1]) + 2
    return is_right(data[start + 1 : start + 1 + length].tobytes(), int(messages.EXTRAS[message]))

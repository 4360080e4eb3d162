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
from flight_replay.tlog.crc import Bytes, checked_rows

Places = NDArray[np.intp]
_MAVLINK2_MARK, _MAVLINK1_MARK = 0xFD, 0xFE
_NO_MESSAGE = 255  # an id that no message has


@dataclass(frozen=True, slots=True)
class Candidates:
    """Start marks in ascending order, every column of shape (n,).

    ``end`` is where the frame would end, or ``start`` where the header is that of no frame;
    ``message`` is the id, or 255 where it takes more than one byte.
    """

    start: Places
    end: Places
    message: NDArray[np.uint8]
    is_mavlink1: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.start)


@dataclass(frozen=True, slots=True)
class Group:
    """Frames of one message and one length: ``start`` (n,), and ``row`` (n, length) without mark and CRC."""

    message: int
    mavlink1: bool
    start: Places
    row: Bytes

    @property
    def payload(self) -> Bytes:
        """The payloads as sent, trimmed or not, shape (n, payload length)."""
        return self.row[:, 5 if self.mavlink1 else 9 :]

    @property
    def vehicle(self) -> NDArray[np.uint16]:
        """System id * 256 + component id, shape (n,)."""
        at = 2 if self.mavlink1 else 4
        return self.row[:, at].astype(np.uint16) << 8 | self.row[:, at + 1]

    def select(self, keep: NDArray[np.bool_]) -> Group:
        """The frames that a mask picks."""
        return Group(self.message, self.mavlink1, self.start[keep], self.row[keep])


def find_records(
    block: Bytes, start: int, stop: int, end: int, wanted: tuple[int, ...]
) -> tuple[list[Group], int]:
    """The wanted records that start in [start, stop), and where the walk goes on, at ``stop`` or later.

    Args:
        block: Bytes; one before ``start`` and ``LONGEST_FRAME`` from ``stop`` on can be read.
        start: Where the walk comes to.
        stop: Where it ends.
        end: Where the data ends; what is behind are no bytes of the log.
        wanted: Ids of messages, all below 255.
    """
    candidates = find_candidates(block, start, stop, end)
    latest_end = np.maximum.accumulate(candidates.end)
    groups = []
    suspects = [np.array([stop], np.intp)]
    for message in wanted:
        for group, index in _checked_groups(block, candidates, message):
            groups.append(group)
            before = latest_end[np.maximum(index - 1, 0)]
            suspects.append(group.start[before > group.start])
    hidden, resume = _hidden(block, candidates, np.concatenate(suspects), stop)
    if len(hidden):
        groups = [group.select(~np.isin(group.start, hidden)) for group in groups]
    return groups, resume


def find_candidates(block: Bytes, start: int, stop: int, end: int) -> Candidates:
    """All start marks in [start, stop), with the frame that each would begin."""
    marks = block[start:stop] - np.uint8(_MAVLINK2_MARK)
    places = np.flatnonzero(marks <= _MAVLINK1_MARK - _MAVLINK2_MARK)
    is_mavlink1 = marks.take(places).view(np.bool_)
    data = block[start:]
    message = data[5:].take(places)
    length = messages.MAVLINK1_FRAME_LENGTHS.take(message.astype(np.uint16) << 8 | data[1:].take(places))
    mavlink2 = np.flatnonzero(~is_mavlink1)
    length[mavlink2], message[mavlink2] = _mavlink2_headers(data, places.take(mavlink2))
    places += start
    ends = places + length
    if stop + messages.LONGEST_FRAME > end:
        np.copyto(ends, places, where=ends > end)
    return Candidates(places, ends, message, is_mavlink1)


def _mavlink2_headers(data: Bytes, places: Places) -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
    """Frame lengths (n,), 0 where there can be no frame, and message ids where they fit one byte.

    Flags that change the frame in a way unknown to the reader make it unreadable by definition;
    the only one known says that it is signed (mavlink.io, "Incompatibility Flags").
    """
    payload, flags, low, mid, high = (data[at:].take(places) for at in (1, 2, 7, 8, 9))
    signature = np.where(flags == 1, messages.SIGNATURE_LENGTH, 0)
    known = (messages.EXTRAS.take(mid.astype(np.uint16) << 8 | low) >= 0) & (high == 0) & (flags <= 1)
    length = np.where(known, payload + signature + messages.MAVLINK2_OVERHEAD, 0)
    return length.astype(np.int32), np.where(mid > 0, np.uint8(_NO_MESSAGE), low)


def _checked_groups(block: Bytes, candidates: Candidates, message: int) -> Iterator[tuple[Group, Places]]:
    """The frames of one message whose CRC is right, by version and length, with their indices."""
    index = np.flatnonzero((candidates.message == message) & (candidates.end > candidates.start))
    for mavlink1, length, members in _by_shape(block, candidates, index):
        start = candidates.start.take(members)
        row, right = checked_rows(block, start, length, int(messages.EXTRAS[message]))
        if not right.all():
            start, row, members = start[right], row[right], members[right]
        yield Group(message, mavlink1, start, row), members


def _by_shape(block: Bytes, candidates: Candidates, index: Places) -> Iterator[tuple[bool, int, Places]]:
    """Indices of candidates grouped by version and by length from behind the mark to before the CRC."""
    payload = block.take(candidates.start.take(index) + 1)
    is_mavlink1 = candidates.is_mavlink1.take(index)
    for mavlink1, header in ((True, 5), (False, 9)):
        of_version = is_mavlink1 == mavlink1
        for length in np.flatnonzero(np.bincount(payload[of_version], minlength=256)):
            yield mavlink1, header + int(length), index[of_version & (payload == length)]


def _hidden(block: Bytes, candidates: Candidates, suspects: Places, stop: int) -> tuple[Places, int]:
    """Which of the suspects (m,) the walk never comes to, and where it goes on from ``stop``.

    ``suspects`` are starts of right frames, and ``stop``. What can hide one is a right frame that
    begins before it and ends behind it, and what can hide that, and so on; a walk over all of
    these alone visits the same of them as the walk over every byte.
    """
    spanning = np.zeros(0, np.intp)
    frontier = suspects
    while len(frontier):
        fresh = np.setdiff1d(_spanning(candidates, frontier), spanning)
        fresh = fresh[_is_right(block, candidates, fresh)]
        spanning = np.union1d(spanning, fresh)
        frontier = candidates.start[fresh]
    if not len(spanning):
        return spanning, stop
    ends = dict(zip(candidates.start[spanning].tolist(), candidates.end[spanning].tolist(), strict=True))
    hidden, resume = [], 0
    for place in sorted({*suspects.tolist(), *ends} - {stop}):
        if place < resume:
            hidden.append(place)
        else:
            resume = ends.get(place, place)
    return np.array(hidden, np.intp), max(resume, stop)


def _spanning(candidates: Candidates, places: Places) -> Places:
    """Indices of the candidates that begin before and end behind one of the places."""
    found = []
    index = np.searchsorted(candidates.start, places) - 1
    while len(index):
        index, places = index[index >= 0], places[index >= 0]
        near = candidates.start[index] > places - messages.LONGEST_FRAME
        index, places = index[near], places[near]
        found.append(index[candidates.end[index] > places])
        index = index - 1
    return np.unique(np.concatenate(found))


def _is_right(block: Bytes, candidates: Candidates, index: Places) -> NDArray[np.bool_]:
    """Whether the CRC of each candidate is right, shape (n,), whichever message it is."""
    right = np.zeros(len(index), np.bool_)
    order = np.arange(len(index))
    for mavlink1, length, members in _by_shape(block, candidates, index):
        start = candidates.start[members]
        low = block[start + (5 if mavlink1 else 7)].astype(np.uint16)
        message = low if mavlink1 else low | block[start + 8].astype(np.uint16) << 8
        right[order[np.isin(index, members)]] = checked_rows(block, start, length, messages.EXTRAS[message])[
            1
        ]
    return right

"""Valid frames that begin inside another valid frame: the walk over every byte never comes to them.

So a frame counts unless one of those that begin before it and end behind its first byte does. All
of these are found by looking back from it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Bytes, Flags, Indices
from flight_replay.logs.tlog.byte_rows import FLAGS_AT_ONCE, rows_at, true_indices
from flight_replay.logs.tlog.core import frame_core
from flight_replay.logs.tlog.frames import HEADER_LENGTH, are_valid_frames, frame_lengths
from flight_replay.logs.tlog.message_table import (
    LONGEST_FRAME,
    MAVLINK1_OVERHEAD,
    MAVLINK1_SHAPES,
    MAVLINK2_OVERHEAD,
    MAVLINK2_STX,
    SIGNATURE_LENGTH,
    SIGNED,
)

LOOK_BACK = LONGEST_FRAME  # bytes up to a place, itself included, in which a frame around it may begin
_AT_ONCE = 3072  # places: those of a slice of a log with one in 700 bytes


def _shortest_payloads(overhead: int) -> Bytes:
    """Shortest payloads of frames around a place, by where they begin in the ``LOOK_BACK`` bytes up to it.

    A frame that begins at the place itself is not around it. Shape (_AT_ONCE * LOOK_BACK,).
    """
    distance = np.arange(LOOK_BACK)[::-1]
    shortest = np.where(distance > 0, np.clip(distance - overhead + 1, 0, 255), 255)
    return np.tile(shortest.astype(np.uint8), _AT_ONCE)


_SHORTEST1 = _shortest_payloads(MAVLINK1_OVERHEAD)
_SHORTEST2 = _shortest_payloads(MAVLINK2_OVERHEAD + SIGNATURE_LENGTH)
_MAVLINK2_BITS = 0xFF | (0xFF & ~SIGNED) << 16  # of a header: start byte, and flags that no frame has
_BUFFERS = np.zeros((3, LOOK_BACK * _AT_ONCE + FLAGS_AT_ONCE), np.uint8)


@dataclass(frozen=True, slots=True, eq=False)
class Enclosures:
    """Pairs of the ``start`` of what may be a frame and a ``place`` that may lie in it, (n,) each."""

    start: Indices
    place: Indices

    def of(self, places: Indices) -> Enclosures:
        """The pairs of these places (n,), which are in ascending order."""
        following = np.append(places, -1).take(np.searchsorted(places, self.place))
        index = (following == self.place).nonzero()[0]
        return Enclosures(self.start.take(index), self.place.take(index))


def joined(parts: list[Enclosures]) -> Enclosures:
    """The pairs of all parts."""
    starts, places = ([_NONE, *(getattr(part, name) for part in parts)] for name in ("start", "place"))
    return Enclosures(np.concatenate(starts), np.concatenate(places))


_NONE: Indices = np.zeros(0, np.intp)


def possible_enclosures(data: Bytes, places: Indices) -> Enclosures:
    """What may be frames around places (n,), of which each has ``LOOK_BACK`` bytes before it in the data."""
    chunks = (places[first : first + _AT_ONCE] for first in range(0, len(places), _AT_ONCE))
    return joined([_look_back(data, chunk) for chunk in chunks])


def _look_back(data: Bytes, places: Indices) -> Enclosures:
    """As above, for at most ``_AT_ONCE`` places."""
    if frame_core.CORE is not None:
        shortest = _SHORTEST1[:LOOK_BACK], _SHORTEST2[:LOOK_BACK]
        return Enclosures(*frame_core.CORE.enclosures(data, places, *shortest))
    before = rows_at(data, places - LOOK_BACK + 1, LOOK_BACK).ravel()
    index = _long_frames(before)
    row = index // LOOK_BACK
    places = places.take(row)
    starts = index - row * LOOK_BACK + places - LOOK_BACK + 1
    some = _may_reach(data, starts, places).nonzero()[0]
    return Enclosures(starts.take(some), places.take(some))


def _long_frames(before: Bytes) -> Indices:
    """Where in rows of bytes up to places there are start bytes with a length that reaches the row's end."""
    length = len(before) - 1
    stx, enough, found = _BUFFERS[:, : length + -length % FLAGS_AT_ONCE]
    found[length:] = 0
    stx, enough, reaches = stx[:length], enough[:length], found[:length].view(np.bool_)
    np.subtract(before[:-1], MAVLINK2_STX, out=stx)  # 0 for MAVLink 2, 1 for MAVLink 1, else more
    np.greater_equal(before[1:], _SHORTEST2[:length], out=enough.view(np.bool_))
    np.greater_equal(before[1:], _SHORTEST1[:length], out=reaches)
    enough += found[:length]  # 1 if that is enough for MAVLink 2, 2 for either
    np.less(stx, enough, out=reaches)
    return true_indices(found.view(np.bool_))


def _may_reach(data: Bytes, starts: Indices, places: Indices) -> Flags:
    """Whether frames may begin at start bytes (n,) and reach places (n,), by most of their headers."""
    header = rows_at(data, starts, 8).view("<i8").ravel()
    payload = header >> 8 & 0xFF
    may = MAVLINK1_SHAPES.take(header >> 32 & 0xFF00 | payload)
    mavlink2 = (header & _MAVLINK2_BITS == MAVLINK2_STX).nonzero()[0]
    length = payload.take(mavlink2) + MAVLINK2_OVERHEAD
    length += SIGNATURE_LENGTH * (header.take(mavlink2) >> 16 & SIGNED)
    may[mavlink2] = starts.take(mavlink2) + length > places.take(mavlink2)
    return may


def enclosing_frames(data: Bytes, possible: Enclosures, enter: int, end: int) -> dict[int, int]:
    """Starts and ends of valid frames around places, of those around their starts, and so on.

    A walk over all of these alone visits the same of the places as the walk over every byte.

    Args:
        data: Bytes.
        possible: What may be frames around the places.
        enter: Where the walk begins: frames before it do not count.
        end: Where the bytes of the log end.
    """
    frames: dict[int, int] = {}
    while len(possible.start):
        found = _valid_enclosures(data, possible, enter, end)
        fresh = sorted(found.keys() - frames.keys())
        frames |= found
        possible = possible_enclosures(data, np.array(fresh, np.intp))
    return frames


def _valid_enclosures(data: Bytes, possible: Enclosures, enter: int, end: int) -> dict[int, int]:
    """Start and end of those that are valid frames, and around their places."""
    start, place = possible.start, possible.place
    stop = start + frame_lengths(rows_at(data, start, HEADER_LENGTH))
    around = ((start < place) & (stop > place) & (start >= enter) & (stop <= end)).nonzero()[0]
    start, first = np.unique(start.take(around), return_index=True)
    valid = are_valid_frames(data, start).nonzero()[0]
    return dict(
        zip(start.take(valid).tolist(), stop.take(around).take(first).take(valid).tolist(), strict=True)
    )


def walk(frames: dict[int, int], places: Iterable[int]) -> tuple[set[int], int]:
    """Which places a walk over frames never comes to, and where the last frame that it visits ends.

    Args:
        frames: Starts and ends, as of ``enclosing_frames``.
        places: Those asked about.
    """
    hidden, walked = set(), 0
    for place in sorted({*places, *frames}):
        if place < walked:
            hidden.add(place)
        else:
            walked = frames.get(place, walked)
    return hidden, walked

"""Which right frames the walk over every byte never comes to, because they lie in another one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from flight_replay.geometry.arrays import Bytes, Indices
from flight_replay.logs.tlog import message_table
from flight_replay.logs.tlog.crc import has_right_crc


def find_hidden(
    data: Bytes, starts: Indices, ends: Indices, suspects: list[int], stop: int
) -> tuple[set[int], int]:
    """Which of the suspects are hidden, and where the walk goes on behind ``stop``.

    What can hide a frame is a right one that begins before it and ends behind it, and what can
    hide that, and so on; a walk over all of these alone visits the same of them as the walk over
    every byte.

    Args:
        data: Bytes.
        starts: Where frames begin that reach over something, right or not, shape (n,), ascending.
        ends: Where they end, shape (n,).
        suspects: Starts of right frames.
        stop: Where the walk ends, unless a frame reaches over it.
    """
    over: dict[int, int] = {}
    frontier: Iterable[int] = {*suspects, stop}
    while frontier:
        found = dict(_frames_over(data, starts, ends, np.array(sorted(frontier))))
        frontier = found.keys() - over.keys()
        over |= found
    hidden, walked = set(), 0
    for place in sorted({*suspects, *over}) if over else []:
        if place < walked:
            hidden.add(place)
        else:
            walked = over.get(place, walked)
    return hidden, max(walked, stop)


def _frames_over(data: Bytes, starts: Indices, ends: Indices, places: Indices) -> Iterator[tuple[int, int]]:
    """Start and end of each right frame that begins before one of the places and ends behind it."""
    firsts = np.searchsorted(starts, places - message_table.LONGEST_FRAME)
    counts = np.searchsorted(starts, places) - firsts
    # All the ranges [first, first + count) one after the other, without a loop.
    near = np.arange(counts.sum()) + np.repeat(firsts - np.cumsum(counts) + counts, counts)
    over = near[ends[near] > np.repeat(places, counts)]
    for start, end in {*zip(starts[over].tolist(), ends[over].tolist(), strict=True)}:
        if is_right_at(data, start):
            yield start, end


def header_length(mavlink1: bool) -> int:
    """Bytes between the start mark and the payload."""
    return 5 if mavlink1 else 9


def is_right_at(data: Bytes, start: int) -> bool:
    """Whether the CRC of the frame that begins there is right, whichever message it is."""
    frame = data[start : start + message_table.LONGEST_FRAME].tobytes()
    mavlink1 = frame[0] == message_table.MAVLINK1_MARK
    message = frame[5] if mavlink1 else frame[7] | frame[8] << 8
    behind = 1 + header_length(mavlink1) + frame[1] + 2
    return has_right_crc(frame[1:behind], int(message_table.EXTRAS[message]))

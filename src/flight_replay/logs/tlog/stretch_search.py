"""Searches stretches of a block for frames of rarer messages, so that reading takes no longer."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Bytes, Indices
from flight_replay.logs.tlog.frame_search import FrameSearch
from flight_replay.logs.tlog.frames import HEADER_LENGTH

REACH = 1 << 16
"""Bytes before a record in which others that belong to it are looked for: seconds of what a radio carries."""
_SLICE_LENGTH = 1 << 21  # bytes searched at a time: more leave the cache


def without_overlaps(begin: Indices, end: Indices) -> tuple[Indices, Indices]:
    """Stretches (n,) in ascending order, each beginning where the one before has ended at the earliest."""
    order = np.argsort(begin, kind="stable")
    begin, end = begin[order], np.maximum.accumulate(end[order])
    begin[1:] = np.maximum(begin[1:], end[:-1])
    some = begin < end
    return begin[some], end[some]


def possible_frames(search: FrameSearch, data: Bytes, begin: Indices, end: Indices) -> list[Indices]:
    """Where frames of each message may begin within stretches, in ascending order.

    All stretches are searched as one: there may be many, mostly short.

    Args:
        search: Knows the messages.
        data: Bytes.
        begin: Where the stretches begin (n,).
        end: Where they end (n,), none behind the beginning of the next.
    """
    length = end - begin + HEADER_LENGTH
    at = np.cumsum(length) - length
    near = np.zeros(int(length.sum()) + HEADER_LENGTH, np.uint8)
    for first, start, size in zip(at.tolist(), begin.tolist(), length.tolist(), strict=True):
        near[first : first + size] = data[start : start + size]
    stop = len(near) - HEADER_LENGTH
    slices = range(0, max(stop, 1), _SLICE_LENGTH)
    parts = [search.find(near, first, min(first + _SLICE_LENGTH, stop)) for first in slices]
    found = []
    for its in zip(*parts, strict=True):
        starts = np.concatenate(its)
        which = np.searchsorted(at, starts, "right") - 1
        inside = starts - at[which]
        found.append((begin[which] + inside)[inside < (end - begin)[which]])
    return found

"""Searches bytes for what may be frames of a few messages, by their headers."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import or_

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Bytes, Indices
from flight_replay.logs.tlog.byte_rows import FLAGS_AT_ONCE, true_indices
from flight_replay.logs.tlog.core import frame_core
from flight_replay.logs.tlog.frames import ID_AT
from flight_replay.logs.tlog.message_table import MAVLINK1_SHAPES, MAVLINK1_STX, MAVLINK2_STX, SIGNED

_PIECE_LENGTH = 1 << 21  # bytes compared at a time: more leave the cache, fewer cost more calls


class FrameSearch:
    """Searches bytes for frames of some messages, whose ids are below 256."""

    def __init__(self, messages: Sequence[int]) -> None:
        self._messages = tuple(messages)
        self._numbers = range(1, len(messages) + 1)  # by which the messages are called here; 0 is none
        self._factor = _telling_factor(messages)
        self._other_bits = ~_product_bits(messages, self._factor) & 255
        self._ids, self._found, self._found2 = np.zeros((3, _PIECE_LENGTH + FLAGS_AT_ONCE), np.uint8)
        self._number_by_id = np.zeros(256, np.uint8)
        self._number_by_id[list(messages)] = self._numbers
        by_shape = MAVLINK1_SHAPES.reshape(256, 256) * self._number_by_id[:, None]
        self._number_by_shape = by_shape.ravel()

    def find(self, data: Bytes, start: int, stop: int) -> list[Indices]:
        """Where frames of each message may begin, from ``start`` to ``stop``: ascending arrays (n,)."""
        if frame_core.CORE is not None:
            ids, shapes = self._messages, self._number_by_shape
            return frame_core.CORE.headers(data, (start, stop), ids, shapes, self._number_by_id)
        pieces = range(start, max(stop, start + 1), _PIECE_LENGTH)
        starts = np.concatenate(
            [self._possible_starts(data, piece, min(piece + _PIECE_LENGTH, stop)) for piece in pieces]
        )
        number = self._message_numbers(data, starts)
        return [starts.take((number == each).nonzero()[0]) for each in self._numbers]

    def _possible_starts(self, data: Bytes, start: int, stop: int) -> Indices:
        """Where in a piece a start byte comes before what may be the id of a message, (n,).

        An id whose product with the factor has a bit which those of no message have is another's. So few
        others pass this test that it pays to look at those alone, and it takes a handful of passes over
        the bytes.
        """
        length = stop - start
        padded = length + -length % FLAGS_AT_ONCE
        ids, found, found2 = self._ids[: length + 2], self._found[:padded], self._found2[:length]
        found[length:] = 1
        np.multiply(data[start + 5 : stop + 7], self._factor, out=ids)
        np.bitwise_and(ids, self._other_bits, out=ids)
        for stx, buffer in (MAVLINK1_STX, found[:length]), (MAVLINK2_STX, found2):
            np.bitwise_xor(data[start:stop], stx, out=buffer)
            np.bitwise_or(buffer, ids[ID_AT[stx] - 5 :][:length], out=buffer)  # 0 where both fit
        np.minimum(found[:length], found2, out=found[:length])
        starts = true_indices(np.equal(found, 0, out=found.view(np.bool_)))
        starts += start
        return starts

    def _message_numbers(self, data: Bytes, starts: Indices) -> NDArray[np.uint8]:
        """Which of the messages frames at start bytes (n,) may hold by their headers, shape (n,)."""
        shape = data[5:].take(starts).astype(np.uint16)
        shape <<= 8
        shape |= data[1:].take(starts)
        number = self._number_by_shape.take(shape)
        mavlink2 = (data.take(starts) == MAVLINK2_STX).nonzero()[0]
        starts = starts.take(mavlink2)
        number2 = self._number_by_id.take(data[7:].take(starts))
        number2 *= data[2:].take(starts) <= SIGNED
        number2 *= data[8:].take(starts) == 0
        number2 *= data[9:].take(starts) == 0
        number[mavlink2] = number2
        return number


def _telling_factor(messages: Sequence[int]) -> int:
    """The odd factor, modulo 256, whose products with the ids have the fewest bits; the largest of these.

    For HEARTBEAT, GPS_RAW_INT and GLOBAL_POSITION_INT that leaves eight ids, none of the others frequent.
    """
    return min(range(255, 0, -2), key=lambda factor: _product_bits(messages, factor).bit_count())


def _product_bits(messages: Sequence[int], factor: int) -> int:
    """The bits that products of the factor with the ids have, modulo 256."""
    return reduce(or_, (message * factor & 255 for message in messages))

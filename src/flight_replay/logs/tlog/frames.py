"""MAVLink frames in bytes: their length by their header, and whether their CRC is valid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Bytes, Flags, Indices
from flight_replay.logs.tlog import message_table
from flight_replay.logs.tlog.byte_rows import rows_at
from flight_replay.logs.tlog.core import frame_core
from flight_replay.logs.tlog.crc import are_crcs_valid, is_crc_valid
from flight_replay.logs.tlog.message_table import MAVLINK1_STX, MAVLINK2_STX

STAMP_LENGTH = 8
HEADER_LENGTH = 10  # that of MAVLink 2, start byte included; MAVLink 1 has 6
ROW_LENGTH = STAMP_LENGTH + HEADER_LENGTH + 30  # a stamp, a header, and the payload bytes that are read
ID_AT = {MAVLINK1_STX: 5, MAVLINK2_STX: 7}  # where in a frame the (lowest byte of the) message id is
_FEW = 16  # frames of one length for which arrays are slower than a loop


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """What may be frames of one message, by their headers, in ascending order.

    ``start`` is the index of each frame's first byte, shape (n,); ``rows`` are the bytes from the
    stamp before it on, shape (n, ROW_LENGTH).
    """

    start: Indices
    rows: Bytes

    def take(self, index: Indices) -> Candidates:
        """Those of an index array."""
        return Candidates(self.start.take(index), self.rows.take(index, axis=0))

    def keep(self, which: Flags) -> Candidates:
        """Those that a mask (n,) picks."""
        return self if which.all() else self.take(which.nonzero()[0])


def frame_lengths(headers: Bytes) -> Indices:
    """Lengths of whole frames (n,) by their first ``HEADER_LENGTH`` bytes or more (n, ...); 0 for no frame.

    Incompatibility flags are those of a signature at most: a frame that has others must not be
    read (mavlink.io, "Incompatibility Flags").
    """
    payload = headers[:, 1].astype(np.intp)
    message = headers[:, ID_AT[MAVLINK1_STX]].astype(np.intp)
    length = payload + message_table.MAVLINK1_OVERHEAD
    length *= message_table.MAVLINK1_SHAPES.take(message << 8 | payload)
    others = (headers[:, 0] != MAVLINK1_STX).nonzero()[0]
    if len(others):
        headers, payload = headers.take(others, axis=0), payload.take(others)
        flags, low, middle, high = headers[:, 2], headers[:, 7], headers[:, 8].astype(np.intp), headers[:, 9]
        is_frame = message_table.EXTRAS.take(middle << 8 | low) >= 0
        is_frame &= (headers[:, 0] == MAVLINK2_STX) & (flags <= message_table.SIGNED) & (high == 0)
        payload += message_table.MAVLINK2_OVERHEAD + flags * np.intp(message_table.SIGNATURE_LENGTH)
        length[others] = payload * is_frame
    return length


def valid_frames(data: Bytes, candidates: Candidates, message: int) -> Flags:
    """Whether the CRC of each candidate of a message (n,) is valid.

    Frames of the same version and length are checked together, unless there are few of them, which
    are most likely none.
    """
    if frame_core.CORE is not None:
        return _valid_by_core(frame_core.CORE, data, candidates)
    start, rows = candidates.start, candidates.rows
    extra = int(message_table.EXTRAS[message])
    valid = np.zeros(len(start), np.bool_)
    shape = rows[:, STAMP_LENGTH + 1].astype(np.intp)
    shape[rows[:, STAMP_LENGTH] == MAVLINK1_STX] += 256
    counts = np.bincount(shape, minlength=1)
    few = (counts <= _FEW).take(shape).nonzero()[0]
    valid[few] = [is_valid_frame(data, at) for at in start.take(few).tolist()]
    for common in (counts > _FEW).nonzero()[0].tolist():
        alike = shape == common
        its = candidates.keep(alike)
        length = _length_to_crc(common >= 256, common % 256)
        if STAMP_LENGTH + length <= ROW_LENGTH:
            frames = its.rows[:, STAMP_LENGTH : STAMP_LENGTH + length]
        else:
            frames = rows_at(data, its.start, length)
        valid[alike] = are_crcs_valid(frames, extra)
    return valid


def _valid_by_core(core: frame_core.FrameCore, data: Bytes, candidates: Candidates) -> Flags:
    """As above; where all frames fit into their rows, those are looked at, which lie side by side."""
    rows = candidates.rows
    if len(rows) and _length_to_crc(False, int(rows[:, STAMP_LENGTH + 1].max())) <= ROW_LENGTH - STAMP_LENGTH:
        starts = np.arange(STAMP_LENGTH, rows.size, ROW_LENGTH)
        return core.are_valid(np.ascontiguousarray(rows).ravel(), starts)
    return core.are_valid(data, candidates.start)


def are_valid_frames(data: Bytes, starts: Indices) -> Flags:
    """Whether the CRCs of a few frames (n,) are valid, whichever messages they are."""
    if frame_core.CORE is not None:
        return frame_core.CORE.are_valid(data, starts)
    return np.fromiter((is_valid_frame(data, at) for at in starts.tolist()), np.bool_, len(starts))


def is_valid_frame(data: Bytes, start: int) -> bool:
    """Whether the CRC of the frame that begins there is valid, whichever message it is."""
    frame = data[start : start + message_table.LONGEST_FRAME].tobytes()
    is_mavlink1 = frame[0] == MAVLINK1_STX
    message = frame[5] if is_mavlink1 else frame[7] | frame[8] << 8
    checked = frame[1 : _length_to_crc(is_mavlink1, frame[1])]
    return is_crc_valid(checked, int(message_table.EXTRAS[message]))


def _length_to_crc(is_mavlink1: bool, payload: int) -> int:
    """The length of a frame from its start byte to its CRC, both included; a signature comes behind."""
    return payload + (message_table.MAVLINK1_OVERHEAD if is_mavlink1 else message_table.MAVLINK2_OVERHEAD)

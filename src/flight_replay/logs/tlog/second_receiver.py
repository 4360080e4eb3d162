"""GPS2_RAW, what a vehicle's second receiver says: of use while the first one has no 3D fix.

So only the bytes are searched in which GPS_RAW_INT says so, from the status before that on, and those at
the ends of a block, of which that is not known.
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Indices
from flight_replay.logs.tlog.blocks import Block
from flight_replay.logs.tlog.byte_rows import rows_at
from flight_replay.logs.tlog.columns import GpsStatus
from flight_replay.logs.tlog.decode import SECOND_FIX_TYPE_AT, decode_gps_status
from flight_replay.logs.tlog.frame_search import FrameSearch
from flight_replay.logs.tlog.frames import HEADER_LENGTH, ROW_LENGTH, STAMP_LENGTH, Candidates
from flight_replay.logs.tlog.message_table import GPS2_RAW
from flight_replay.logs.tlog.stretch_search import REACH, possible_frames, without_overlaps

_SEARCH = FrameSearch((GPS2_RAW,))
_ROW_LENGTH = STAMP_LENGTH + HEADER_LENGTH + SECOND_FIX_TYPE_AT + 1


def second_receivers(block: Block, enter: int, gps: GpsStatus) -> tuple[Candidates, GpsStatus]:
    """What may be frames of GPS2_RAW where they may be of use, and what each says.

    Args:
        block: The block.
        enter: Where the walk comes into it.
        gps: GPS_RAW_INT in the block, of each vehicle at least the ones before and after a change.
    """
    starts = np.zeros(0, np.intp)
    if len(gps):
        (starts,) = possible_frames(_SEARCH, block.data, *_stretches(gps, enter, block))
    if not len(starts):
        return block.gps.take(starts), gps.select(starts)
    rows = rows_at(block.data, starts - STAMP_LENGTH, _ROW_LENGTH)
    status = decode_gps_status(Candidates(starts, rows), SECOND_FIX_TYPE_AT)
    return Candidates(starts, np.ascontiguousarray(rows[:, :ROW_LENGTH])), status


def _stretches(gps: GpsStatus, enter: int, block: Block) -> tuple[Indices, Indices]:
    """Where to look: up to first statuses, around those without a 3D fix, and at the end of the block."""
    stop = block.stop
    last = max(stop - REACH, enter) if stop < block.end else stop  # no block follows the last one
    order = np.lexsort((gps.offset, gps.vehicle))
    vehicle, at, has_fix = gps.vehicle[order], gps.offset[order], gps.has_3d_fix[order]
    is_first = np.diff(vehicle.astype(np.int64), prepend=-1) != 0
    before = np.where(is_first, enter, np.append(enter, at[:-1]))
    after = np.where(np.append(is_first[1:], True), stop, np.append(at[1:], stop))
    lost = ~has_fix
    begin = np.concatenate([before[lost | is_first], at[lost], [last]])
    end = np.concatenate([at[lost | is_first], after[lost], [stop]])
    return without_overlaps(begin, end)

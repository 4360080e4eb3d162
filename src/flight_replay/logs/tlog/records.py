"""The records in a block, once it is known where the walk comes into it.

Of what repeats, only the ends of each run are kept, so that memory stays constant for logs that
hold no position but many of the other records.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Indices
from flight_replay.logs.tlog.arming_reports import arming_reports
from flight_replay.logs.tlog.blocks import Block
from flight_replay.logs.tlog.columns import AnyMessage, Positions, Records
from flight_replay.logs.tlog.decode import decode_gps_status, decode_heartbeats, decode_positions
from flight_replay.logs.tlog.frame_walk import Walk
from flight_replay.logs.tlog.frames import Candidates, valid_frames
from flight_replay.logs.tlog.message_table import GLOBAL_POSITION_INT, GPS_RAW_INT, HEARTBEAT


def read_records(block: Block, enter: int) -> tuple[Records, int]:
    """The records in a block that the walk comes into at ``enter``, and where it goes on.

    Both are offsets in the log.
    """
    walk = Walk(block.data, enter - block.offset, block.stop, block.end)
    positions, empty = _positions(block, walk)
    heartbeats = decode_heartbeats(_valid(block, block.heartbeats, HEARTBEAT, walk))
    status = heartbeats.type.astype(np.int32) << 17 | heartbeats.autopilot.astype(np.int32) << 9
    status |= heartbeats.mode.astype(np.int32) << 1 | heartbeats.armed
    heartbeats = _run_ends(heartbeats, status, walk)
    gps = decode_gps_status(_valid(block, block.gps, GPS_RAW_INT, walk))
    gps = _run_ends(gps, gps.has_3d_fix, walk)
    reports = arming_reports(block, walk, heartbeats)
    records = Records(
        replace(positions, offset=positions.offset + block.offset),
        replace(heartbeats, offset=heartbeats.offset + block.offset),
        replace(gps, offset=gps.offset + block.offset),
        replace(reports, offset=reports.offset + block.offset),
        empty,
    )
    return records, walk.leave + block.offset


def _valid(block: Block, candidates: Candidates, message: int, walk: Walk) -> Candidates:
    """The valid frames of a message from where the walk enters."""
    valid = valid_frames(block.data, candidates, message) & (candidates.start >= walk.enter)
    return candidates if valid.all() else candidates.take(np.flatnonzero(valid))


def _positions(block: Block, walk: Walk) -> tuple[Positions, dict[int, int]]:
    """The positions that the walk comes to, but for the inner ones of runs of empty ones.

    Also counts the empty ones by vehicle.
    """
    positions = decode_positions(_valid(block, block.positions, GLOBAL_POSITION_INT, walk))
    positions = positions.select(walk.visits(positions.offset, block.enclosures))
    is_empty = positions.is_empty
    if not is_empty.any():
        return positions, {}
    vehicle = positions.vehicle
    counts = np.bincount(vehicle[is_empty])
    kept = _are_run_ends(vehicle, np.where(is_empty, _falls(positions.time_ms), -1))
    empty = {key: int(counts[key]) for key in np.flatnonzero(counts).tolist()}
    return positions.select(kept | ~is_empty), empty


def _run_ends(columns: AnyMessage, status: NDArray[Any], walk: Walk) -> AnyMessage:
    """The first and last records of each run in which a vehicle's status (n,) stays the same.

    Whether the walk comes to them is asked of these only: within a run it makes no difference.
    """
    ends = _are_run_ends(columns.vehicle, status)
    if not walk.visits(columns.offset[ends]).all():
        visited = walk.visits(columns.offset)
        columns, status = columns.select(visited), status[visited]
        ends = _are_run_ends(columns.vehicle, status)
    return columns.select(ends)


def _falls(time_ms: NDArray[np.uint32]) -> Indices:
    """How often a clock has fallen so far, shape (n,)."""
    return np.cumsum(time_ms < np.concatenate([time_ms[:1], time_ms[:-1]]))


def _are_run_ends(vehicle: NDArray[np.uint16], value: NDArray[Any]) -> Flags:
    """Where a vehicle's value begins or ends a run of equal ones, shape (n,)."""
    order = np.arange(len(vehicle))
    if (vehicle[1:] != vehicle[:-1]).any():
        order = np.argsort(vehicle, kind="stable")
        vehicle, value = vehicle[order], value[order]
    same = (vehicle[1:] == vehicle[:-1]) & (value[1:] == value[:-1])
    ends = np.ones(len(vehicle), np.bool_)
    ends[order[1:-1]] = ~(same[1:] & same[:-1])
    return ends

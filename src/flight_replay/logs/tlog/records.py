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
from flight_replay.logs.tlog.arming.arming_reports import arming_reports
from flight_replay.logs.tlog.blocks import Block
from flight_replay.logs.tlog.columns import Positions, Records
from flight_replay.logs.tlog.decode import decode_gps_status, decode_heartbeats, decode_positions
from flight_replay.logs.tlog.frame_walk import Walk
from flight_replay.logs.tlog.frames import Candidates
from flight_replay.logs.tlog.message_table import GLOBAL_POSITION_INT, GPS2_RAW, GPS_RAW_INT, HEARTBEAT
from flight_replay.logs.tlog.second_receiver import second_receivers


def read_records(block: Block, enter: int) -> tuple[Records, int]:
    """The records in a block that the walk comes into at ``enter``, and where it goes on.

    Both are offsets in the log.
    """
    walk = Walk(block.data, enter - block.offset, block.stop, block.end)
    positions, empty = _positions(block, walk)
    heartbeats = decode_heartbeats(block.heartbeats)
    status = heartbeats.type.astype(np.int32) << 17 | heartbeats.autopilot.astype(np.int32) << 9
    status |= heartbeats.mode.astype(np.int32) << 1 | heartbeats.armed
    heartbeats = heartbeats.select(_run_ends(block.heartbeats, HEARTBEAT, heartbeats.vehicle, status, walk))
    gps = decode_gps_status(block.gps)
    gps = gps.select(_run_ends(block.gps, GPS_RAW_INT, gps.vehicle, gps.fix, walk))
    candidates, gps2 = second_receivers(block, walk.enter, gps)
    if len(gps2):
        gps2 = gps2.select(_run_ends(candidates, GPS2_RAW, gps2.vehicle, gps2.fix, walk))
    reports = arming_reports(block, walk, heartbeats)
    records = Records(
        replace(positions, offset=positions.offset + block.offset),
        replace(heartbeats, offset=heartbeats.offset + block.offset),
        replace(gps, offset=gps.offset + block.offset),
        replace(gps2, offset=gps2.offset + block.offset),
        replace(reports, offset=reports.offset + block.offset),
        empty,
    )
    return records, walk.leave + block.offset


def _positions(block: Block, walk: Walk) -> tuple[Positions, dict[int, int]]:
    """The positions that the walk comes to, but for the inner ones of runs of empty ones.

    Also counts the empty ones by vehicle.
    """
    are_records = walk.visits_valid(block.positions, GLOBAL_POSITION_INT, block.enclosures)
    positions = decode_positions(block.positions.keep(are_records))
    is_empty = positions.is_empty
    if not is_empty.any():
        return positions, {}
    vehicle = positions.vehicle
    counts = np.bincount(vehicle[is_empty])
    _, kept = _runs(vehicle, np.where(is_empty, _falls(positions.time_ms), -1))
    empty = {key: int(counts[key]) for key in np.flatnonzero(counts).tolist()}
    return positions.select(kept | ~is_empty), empty


def _run_ends(
    candidates: Candidates, message: int, vehicle: NDArray[np.uint16], status: NDArray[Any], walk: Walk
) -> Indices:
    """The first and last records of each run in which a vehicle's status stays the same: indices (m,).

    Whether candidates are records is asked of the first and last of each run of them, as within a run it
    makes no difference, and of whole runs only where one of these is none.

    Args:
        candidates: Candidates of a message (n,).
        message: The message.
        vehicle: The vehicle that sent each, if it is a record (n,).
        status: The status that each tells of (n,).
        walk: The walk through them.
    """
    run, are_ends = _runs(vehicle, status)
    ends = are_ends.nonzero()[0]
    are_records = walk.visits_valid(candidates.take(ends), message)
    if are_records.all():
        return ends
    is_doubtful = np.zeros(len(run) + 1, np.bool_)
    is_doubtful[run[ends[~are_records]]] = True
    inner = (is_doubtful[run] & ~are_ends).nonzero()[0]
    inner_records = walk.visits_valid(candidates.take(inner), message)
    left = np.delete(np.arange(len(run)), np.append(ends[~are_records], inner[~inner_records]))
    return left[_runs(vehicle[left], status[left])[1]]


def _falls(time_ms: NDArray[np.uint32]) -> Indices:
    """How often a clock has fallen so far, shape (n,)."""
    return np.cumsum(time_ms < np.concatenate([time_ms[:1], time_ms[:-1]]))


def _runs(vehicle: NDArray[np.uint16], value: NDArray[Any]) -> tuple[Indices, Flags]:
    """The number of the run of equal values of a vehicle that each is in, and whether it is at an end of it.

    Both of shape (n,).
    """
    if (vehicle == vehicle[:1]).all():
        ends = np.ones(len(value) + 1, np.bool_)
        ends[1:-1] = value[1:] != value[:-1]
        return np.cumsum(ends[:-1]), ends[:-1] | ends[1:]
    order = np.argsort(vehicle, kind="stable")
    vehicle, value = vehicle[order], value[order]
    begins, are_ends = np.ones((2, len(order) + 1), np.bool_)
    begins[1:-1] = (vehicle[1:] != vehicle[:-1]) | (value[1:] != value[:-1])
    run = np.empty(len(order), np.intp)
    run[order] = np.cumsum(begins[:-1])
    are_ends[order] = begins[:-1] | begins[1:]
    return run, are_ends[:-1]

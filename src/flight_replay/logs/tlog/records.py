"""Records out of what marked bytes may say, once it is known where the walk enters them.

Of what says nothing new, only the ends of each run are kept, so that memory stays constant
for logs that hold no position but many of the other records.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Indices
from flight_replay.logs.tlog.columns import Fixes, Heartbeats, Positions, Records
from flight_replay.logs.tlog.decode import Decoded, States
from flight_replay.logs.tlog.frame_walk import Walk


def read_records(decoded: Decoded, walk: Walk, base: int) -> Records:
    """Columns of the records that a walk finds in bytes which begin ``base`` bytes into the log."""
    positions, empty = _positions(decoded.positions, walk)
    heartbeats = _run_ends_found(decoded.heartbeats, walk)
    fixes = _run_ends_found(decoded.fixes, walk)
    state = heartbeats.state
    return Records(
        replace(positions, offset=positions.offset + base),
        Heartbeats(
            offset=heartbeats.candidates.start + base,
            vehicle=heartbeats.vehicle,
            autopilot=(state >> 8).astype(np.uint8),
            type=(state >> 16).astype(np.uint8),
            armed=(state & 255) != 0,
        ),
        Fixes(fixes.candidates.start + base, fixes.vehicle, fixes.state != 0),
        empty,
    )


def _positions(right: Positions, walk: Walk) -> tuple[Positions, dict[int, int]]:
    """The positions that a walk comes to, but for the inner ones of runs of empty ones.

    Also counts the empty ones by vehicle.
    """
    entered = right.offset >= walk.enter
    positions = right.select(entered)
    positions = positions.select(walk.visits(positions.offset))
    is_empty = positions.is_empty
    if not is_empty.any():
        return positions, {}
    vehicle = positions.vehicle
    counts = np.bincount(vehicle[is_empty])
    run_ends = _are_run_ends(vehicle, np.where(is_empty, _falls(positions.time_ms), -1))
    empty = {key: int(counts[key]) for key in np.flatnonzero(counts).tolist()}
    return positions.select(run_ends | ~is_empty), empty


def _run_ends_found(states: States, walk: Walk) -> States:
    """The records at which a vehicle's state begins or ends to be reported.

    Only these are checked, and where one is no record, all that tell the same: whether other
    frames within a run are records makes no difference.
    """

    def are_records(index: Indices) -> Flags:
        checked[index] = True
        return walk.finds(states.candidates.take(index), states.message)

    said = states.vehicle.astype(np.int64) << 32 | states.state
    checked = np.zeros(len(said), np.bool_)
    is_left = states.candidates.start >= walk.enter
    while True:
        left = np.flatnonzero(is_left)
        ends = left[_are_run_ends(states.vehicle[left], states.state[left])]
        fresh = ends[~checked[ends]]
        right = are_records(fresh)
        if right.all():
            return states.take(ends)
        is_left[fresh] = right
        unsaid = np.sort(said[fresh[~right]])
        alike = unsaid.take(np.searchsorted(unsaid, said), mode="clip") == said
        alike_left = np.flatnonzero(alike & is_left & ~checked)
        is_left[alike_left] = are_records(alike_left)


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

"""What autopilots say at the moment they arm or disarm: STATUSTEXT, and COMMAND_ACK of the command to.

Heartbeats tell of it up to a second later. These messages lie between the two heartbeats of the change;
so only bytes before a heartbeat that may tell of one are searched, and reading takes no longer.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Indices
from flight_replay.logs.tlog.blocks import Block
from flight_replay.logs.tlog.byte_rows import rows_at
from flight_replay.logs.tlog.columns import ArmingReports, Heartbeats
from flight_replay.logs.tlog.decode import PayloadFields
from flight_replay.logs.tlog.frame_search import FrameSearch
from flight_replay.logs.tlog.frame_walk import Walk
from flight_replay.logs.tlog.frames import ROW_LENGTH, STAMP_LENGTH, Candidates, valid_frames
from flight_replay.logs.tlog.message_table import COMMAND_ACK, STATUSTEXT
from flight_replay.logs.tlog.stretch_search import REACH, possible_frames, without_overlaps
from flight_replay.logs.track import Armed

# Of ArduCopter, of ArduPlane and Rover, and of PX4. "PreArm: ..." and "Arm: ..." are refusals.
_TEXT = re.compile(rb"(dis)?arm(?:ing motors|ed by )|throttle (dis)?armed", re.IGNORECASE)
_TEXT_LENGTH = 24
_ARM_DISARM, _ACCEPTED = 400, 0  # MAV_CMD_COMPONENT_ARM_DISARM, MAV_RESULT_ACCEPTED
_NO_REPORT = -2  # unlike all of Armed
_SEARCH = FrameSearch((STATUSTEXT, COMMAND_ACK))


def arming_reports(block: Block, walk: Walk, heartbeats: Heartbeats) -> ArmingReports:
    """The reports that the walk through a block comes to, where they may be of use.

    Args:
        block: The block.
        walk: The walk.
        heartbeats: Those in the block, of each vehicle at least the ones before and after a change.
    """
    texts, acks = possible_frames(_SEARCH, block.data, *_stretches(heartbeats, walk.enter, block.stop))
    reports = [
        _reports(block, walk, texts, STATUSTEXT),
        _reports(block, walk, acks, COMMAND_ACK),
    ]
    return ArmingReports(
        np.concatenate([each.offset for each in reports]),
        np.concatenate([each.vehicle for each in reports]),
        np.concatenate([each.armed for each in reports]),
    )


def _stretches(heartbeats: Heartbeats, enter: int, stop: int) -> tuple[Indices, Indices]:
    """Where to look: before first heartbeats, before changes, and at the block's end.

    Begins and ends (n,), ascending and without overlaps.
    """
    order = np.lexsort((heartbeats.offset, heartbeats.vehicle))
    vehicle, armed, end = heartbeats.vehicle[order], heartbeats.armed[order], heartbeats.offset[order]
    may_change = np.ones(len(order), np.bool_)
    may_change[1:] = (vehicle[1:] != vehicle[:-1]) | (armed[1:] != armed[:-1])
    begin = np.maximum(end - REACH, enter)
    begin[1:] = np.where(vehicle[1:] == vehicle[:-1], np.maximum(begin[1:], end[:-1]), begin[1:])
    begin = np.append(begin[may_change], max(stop - REACH, enter))
    return without_overlaps(begin, np.append(end[may_change], stop))


def _reports(block: Block, walk: Walk, starts: Indices, message: int) -> ArmingReports:
    """The frames of a message that are valid, that the walk comes to, and that tell of arming."""
    frames = Candidates(starts, rows_at(block.data, starts - STAMP_LENGTH, ROW_LENGTH))
    fields = PayloadFields(frames.rows)
    armed = _armed_by_text(fields) if message == STATUSTEXT else _armed_by_ack(fields)
    some = np.flatnonzero(armed != _NO_REPORT)
    some = some[valid_frames(block.data, frames.take(some), message)]
    reports = ArmingReports(starts[some], fields.vehicle[some], armed[some])
    return reports.select(walk.visits(reports.offset)) if len(reports) else reports


def _armed_by_text(fields: PayloadFields) -> NDArray[np.int8]:
    """What STATUSTEXT says: behind a byte of severity follows the text."""
    texts = np.ascontiguousarray(fields.payload(1 + _TEXT_LENGTH)[:, 1:]).view(f"S{_TEXT_LENGTH}").ravel()
    matches = [_TEXT.match(text) for text in texts.tolist()]
    states = (
        _NO_REPORT if each is None else Armed.NO if any(each.groups()) else Armed.YES for each in matches
    )
    return np.fromiter(states, np.int8, len(matches))


def _armed_by_ack(fields: PayloadFields) -> NDArray[np.int8]:
    """What COMMAND_ACK says: the command was accepted, whether to arm or to disarm."""
    payload = fields.payload(3)
    command = payload[:, 0] | payload[:, 1].astype(np.uint16) << 8
    is_accepted = (command == _ARM_DISARM) & (payload[:, 2] == _ACCEPTED)
    return np.where(is_accepted, Armed.UNKNOWN, _NO_REPORT).astype(np.int8)


def with_reports(heartbeats: Heartbeats, reports: ArmingReports) -> Heartbeats:
    """The heartbeats, those that tell of a change moved to the first report of it.

    A report counts only between the two heartbeats around the change, so that a wrong one cannot move it
    by more than what was unknown before.

    Args:
        heartbeats: Of one vehicle's autopilot, in the order of the log.
        reports: Under the same ids.
    """
    offset = heartbeats.offset.copy()
    changes = np.flatnonzero(np.diff(heartbeats.armed)) + 1
    for other in (Armed.NO, Armed.YES):
        told = np.sort(reports.offset[reports.armed != other])
        its = changes[heartbeats.armed[changes] != (other == Armed.YES)]
        after = np.maximum(heartbeats.offset[its - 1], heartbeats.offset[its] - REACH)
        first = np.append(told, np.iinfo(np.int64).max)[np.searchsorted(told, after, "right")]
        offset[its] = np.minimum(offset[its], first)
    return replace(heartbeats, offset=offset)

"""When a vehicle was armed, by the EV and ARM records of its DataFlash log.

Events may be missing: logging often begins with arming and ends with disarming. So before its first
event a vehicle was in the opposite state, and two events of arming in a row are two flights.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Indices, Integers
from flight_replay.logs.dataflash.log_sections import LogSections
from flight_replay.logs.dataflash.message_rows import Offsets
from flight_replay.logs.dataflash.message_tables import ArmEvents
from flight_replay.logs.dataflash.row_slices import slices
from flight_replay.logs.track import Armed

_SAME_EVENT_S = 1.0  # EV and ARM tell of one arming


def armed_at(
    offset: Offsets, events: ArmEvents, sections: LogSections, logs_when_disarmed: bool | None
) -> NDArray[np.int8]:
    """Whether the motors were armed at positions (n,), as ``Armed``.

    Where a vehicle was disarmed and armed again between two positions, the first is not armed, so that
    two flights stay two.

    Args:
        offset: Where the positions are in the log (n,), in order.
        events: All events, in the order of the log.
        sections: The sections of the log: an event tells nothing of another one.
        logs_when_disarmed: Whether the vehicle logs while disarmed too, None where that is not known.
    """
    eventless = Armed.YES if logs_when_disarmed is False else Armed.UNKNOWN
    armed = np.full(len(offset), eventless, np.int8)
    if not len(events) or not len(offset):
        return armed
    event_section = sections.of(events.offset)
    for part in slices(len(offset)):
        section = sections.of(offset[part])
        behind = np.searchsorted(events.offset, offset[part])
        before, behind = behind - 1, np.minimum(behind, len(events) - 1)
        armed[part] = np.where(event_section[behind] == section, ~events.armed[behind], armed[part])
        has_before = (before >= 0) & (event_section[before] == section)
        armed[part] = np.where(has_before, events.armed[before], armed[part])
    again = np.searchsorted(offset, events.offset[_are_armings(events, event_section)])
    again = again[(again > 0) & (again < len(offset))]
    is_one_section = sections.of(offset[again]) == sections.of(offset[again - 1])
    again = again[is_one_section & (armed[again] == Armed.YES)]
    armed[again - 1] = Armed.NO
    return armed


def _are_armings(events: ArmEvents, section: Integers) -> Flags:
    """Which events (n,) tell of arming, each arming but once."""
    is_same = np.zeros(len(events), np.bool_)
    is_same[1:] = events.armed[:-1] & (section[1:] == section[:-1])
    is_same[1:] &= np.abs(np.diff(events.time_s)) <= _SAME_EVENT_S
    return events.armed & ~is_same


def first_armed(section: Integers, armed: NDArray[np.int8]) -> Indices:
    """The first position of each run of armed ones within a section, both (n,)."""
    is_armed = armed == Armed.YES
    begins = is_armed.copy()
    begins[1:] &= ~is_armed[:-1] | (section[1:] != section[:-1])
    return np.flatnonzero(begins)

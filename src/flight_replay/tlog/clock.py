"""The vehicle's clock: ``time_boot_ms`` carried on over wraps and reboots, so that time never falls.

A falling clock is a reboot and begins a new section, but for two kinds of falls: the 32-bit
counter wraps after 49.7 days, and datagrams arrive out of order. Log stamps, which are often
wrong, only say how long a reboot took, and only if they can be right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.geodesy import Floats
from flight_replay.tlog.columns import Table

_WRAP_MS = 1 << 32
_WRAP_GAP_MS = 3_600_000  # a fall by nearly a whole turn is a wrap if no more than this is missing
_LATE_ROWS = 16  # how many records may arrive late in a row
_EARLIEST_STAMP_US = 946_684_800_000_000  # 2000, before there was MAVLink
_LATEST_STAMP_US = 4_102_444_800_000_000  # 2100
_LONGEST_REBOOT_S = 86_400.0  # beyond a day, stamps of two boots say nothing about one flight


@dataclass(frozen=True, slots=True, eq=False)
class Clock:
    """For records put in ``order`` (n,), by section and time: their time and their section, both (n,)."""

    order: NDArray[np.intp]
    time_s: Floats
    section: NDArray[np.int32]


def read_clock(positions: Table) -> Clock:
    """The clock of one vehicle's records, which come in the order of the log."""
    clock_ms = _unwrapped(positions["time_ms"].astype(np.int64))
    reboots = _reboots(clock_ms)
    section = np.zeros(len(clock_ms), np.int32)
    section[reboots] = 1
    section = np.cumsum(section, dtype=np.int32)
    order = np.arange(len(clock_ms))
    if (np.diff(clock_ms) < 0).sum() > len(reboots):
        order = np.lexsort((clock_ms, section))
    time_s = clock_ms[order] / 1000.0
    for index, first in enumerate(reboots):
        last = reboots[index + 1] if index + 1 < len(reboots) else len(time_s)
        gap_s = _stamp_gap_s(positions["stamp_us"][first - 1], positions["stamp_us"][first])
        time_s[first:last] += time_s[first - 1] + gap_s - time_s[first]
    return Clock(order, time_s, section)


def _unwrapped(time_ms: NDArray[np.int64]) -> NDArray[np.int64]:
    """The counter as if it had more bits."""
    step = np.diff(time_ms)
    around = (step + _WRAP_MS // 2) % _WRAP_MS - _WRAP_MS // 2
    wraps = (around != step) & (np.abs(around) < _WRAP_GAP_MS)
    if not wraps.any():
        return time_ms
    turns = np.cumsum(np.where(wraps, np.sign(around - step), 0))
    return time_ms + _WRAP_MS * np.concatenate([[0], turns])


def _reboots(clock_ms: NDArray[np.int64]) -> NDArray[np.intp]:
    """Indices at which a boot begins: the clock fell, and not for late records alone.

    After late records the clock leaps back to where it was; a rebooted one has to run there.
    """
    falls = np.flatnonzero(np.diff(clock_ms) < 0) + 1
    late = np.zeros(len(falls), np.bool_)
    before = clock_ms[falls - 1]
    half_way = (before + clock_ms[falls]) // 2
    waiting = np.arange(len(falls))
    for row in range(1, _LATE_ROWS + 1):
        index = np.minimum(falls[waiting] + row, len(clock_ms) - 1)
        is_back = clock_ms[index] >= before[waiting]
        late[waiting[is_back]] = True
        waiting = waiting[~is_back & (clock_ms[index] <= half_way[waiting])]
    return falls[~late]


def _stamp_gap_s(before_us: int, after_us: int) -> float:
    """Seconds between two log stamps, 0 where they cannot be right."""
    plausible = _EARLIEST_STAMP_US < before_us <= after_us < _LATEST_STAMP_US
    gap_s = (int(after_us) - int(before_us)) / 1e6 if plausible else 0.0
    return gap_s if gap_s <= _LONGEST_REBOOT_S else 0.0

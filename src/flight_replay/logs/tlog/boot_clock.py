"""The vehicle's clock: ``time_boot_ms`` carried on over wraps and reboots, so that time never falls.

A falling clock is a reboot, but for two kinds of falls: the 32-bit
counter wraps after 49.7 days, and datagrams arrive out of order. Log stamps, which are often
wrong, only say how long a reboot took, or how time went on for a vehicle whose clock stands
still, and only if they can be right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.logs.tlog.columns import Positions

_WRAP_MS = 1 << 32
_WRAP_GAP_MS = 3_600_000  # a fall by nearly a whole turn is a wrap if no more than this is missing
_LATE_ROWS = 16  # how many records may arrive late in a row
_EARLIEST_STAMP_US = 946_684_800_000_000  # 2000, before there was MAVLink
_LATEST_STAMP_US = 4_102_444_800_000_000  # 2100
_LONGEST_REBOOT_US = 86_400_000_000  # beyond a day, stamps of two boots say nothing about one flight


@dataclass(frozen=True, slots=True, eq=False)
class BootClock:
    """Time and boot of records in the order of the log, and the ``order`` of time, all (n,).

    ``order`` is None where it is that of the log.
    """

    time_s: Floats
    boot: NDArray[np.int32]
    order: Indices | None

    def in_order(self, keep: Flags) -> Indices:
        """The indices that a mask (n,) keeps, in the order of time."""
        return np.flatnonzero(keep) if self.order is None else self.order[keep[self.order]]


def read_clock(positions: Positions) -> BootClock:
    """The clock of one vehicle's records, of which there is at least one."""
    clock_ms = _unwrapped(_running_ms(positions))
    falls = np.flatnonzero(clock_ms[1:] < clock_ms[:-1]) + 1
    reboots = falls[~_is_late(clock_ms, falls)]
    bounds = np.concatenate([[0], reboots, [len(clock_ms)]])
    boot = np.repeat(np.arange(len(reboots) + 1, dtype=np.int32), np.diff(bounds))
    order = np.lexsort((clock_ms, boot)) if len(falls) > len(reboots) else None
    firsts, lasts = bounds[:-1], bounds[1:] - 1
    first_us, last_us = (clock_ms[ends if order is None else order[ends]] * 1000 for ends in (firsts, lasts))
    gap_us = _stamp_gaps_us(positions.stamp_us[reboots - 1], positions.stamp_us[reboots])
    shift_us = np.concatenate([[0], np.cumsum(last_us[:-1] + gap_us - first_us[1:])])
    clock_ms *= 1000
    clock_ms += shift_us[boot]
    return BootClock(clock_ms / 1e6, boot, order)


def _running_ms(positions: Positions) -> NDArray[np.int64]:
    """The vehicle's clock (n,), moved by the stamps where it stands still, as that of senders without one."""
    time_ms, stamp_us = positions.time_ms.astype(np.int64), positions.stamp_us
    if time_ms[0] == time_ms[-1] and (time_ms == time_ms[0]).all():
        time_ms[1:] += np.cumsum(_stamp_gaps_us(stamp_us[:-1], stamp_us[1:])) // 1000
    return time_ms


def _unwrapped(time_ms: NDArray[np.int64]) -> NDArray[np.int64]:
    """The counter as if it had more bits, shape (n,)."""
    step = np.diff(time_ms)
    most = _WRAP_MS - _WRAP_GAP_MS
    wraps = np.flatnonzero((step > most) | (step < -most)) + 1
    if not len(wraps):
        return time_ms
    turns = np.zeros(len(time_ms), np.int64)
    turns[wraps] = -np.sign(step[wraps - 1])
    return np.asarray(time_ms + _WRAP_MS * np.cumsum(turns))


def _is_late(clock_ms: NDArray[np.int64], falls: Indices) -> Flags:
    """Which falls (m,) of the clock mean that records come late, not that the vehicle booted.

    After late records the clock leaps back to where it was; a rebooted one has to run there.
    """
    late = np.zeros(len(falls), np.bool_)
    before = clock_ms[falls - 1]
    half_way = (before + clock_ms[falls]) // 2
    waiting = np.arange(len(falls))
    for row in range(1, _LATE_ROWS + 1):
        waiting = waiting[falls[waiting] + row < len(clock_ms)]
        now = clock_ms[falls[waiting] + row]
        late[waiting[now >= before[waiting]]] = True
        waiting = waiting[now <= half_way[waiting]]
    return late


def _stamp_gaps_us(before_us: NDArray[np.int64], after_us: NDArray[np.int64]) -> NDArray[np.int64]:
    """Microseconds between log stamps (m,), 0 where they cannot be right."""
    plausible = (before_us > _EARLIEST_STAMP_US) & (before_us <= after_us) & (after_us < _LATEST_STAMP_US)
    gaps_us = np.where(plausible, after_us - before_us, 0)
    return np.where(gaps_us <= _LONGEST_REBOOT_US, gaps_us, 0)

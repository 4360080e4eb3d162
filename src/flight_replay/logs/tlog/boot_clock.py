"""The vehicle's clock: ``time_boot_ms`` carried on over wraps and reboots, so that time never falls.

A falling clock is a reboot, but for two kinds of falls: the 32-bit counter wraps after 49.7 days,
and datagrams arrive out of order. Log stamps, which are often wrong, only say how long a reboot
took, or how time went on for a vehicle whose clock stands still, and only if they can be right.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.logs.tlog.columns import Positions

Integers = NDArray[np.int64]
Number = TypeVar("Number", bound=np.generic)

_WRAP_MS = 1 << 32
_WRAP_GAP_MS = 3_600_000  # a fall by nearly a whole turn is a wrap if no more than this is missing
_LATE_ROWS = 16  # how many records may arrive late in a row
_EARLIEST_STAMP_US = 946_684_800_000_000  # 2000, before there was MAVLink
_LATEST_STAMP_US = 4_102_444_800_000_000  # 2100
_LONGEST_REBOOT_US = 86_400_000_000  # beyond a day, stamps of two boots say nothing about one flight


@dataclass(frozen=True, slots=True, eq=False)
class BootClock:
    """Time and boot of records in the order given, and the ``order`` of time within vehicles, all (n,).

    Each vehicle's clock runs for itself; boots are numbered on from vehicle to vehicle. ``order`` is
    None where it is the one given.
    """

    time_s: Floats
    boot: NDArray[np.int32]
    order: Indices | None

    def in_order(self, keep: Flags) -> Indices:
        """The indices that a mask (n,) keeps, in the order of time."""
        return np.flatnonzero(keep) if self.order is None else self.order[keep[self.order]]


def read_clock(positions: Positions) -> BootClock:
    """The clocks of vehicles, one vehicle's records after the other's; of each there is one at least."""
    vehicles = _Runs(np.flatnonzero(np.diff(positions.vehicle, prepend=-1)), len(positions))
    clock_ms = _unwrapped(_running_ms(positions, vehicles), vehicles)
    falls = np.flatnonzero(clock_ms[1:] < clock_ms[:-1]) + 1
    falls = falls[~np.isin(falls, vehicles.first)]
    reboots = falls[~_is_late(clock_ms, falls, vehicles.end_of(falls))]
    boots = _Runs(np.sort(np.append(vehicles.first, reboots)), len(positions))
    boot = boots.spread(np.arange(len(boots.first), dtype=np.int32))
    order = np.lexsort((clock_ms, boot)) if len(falls) > len(reboots) else None
    first_us, last_us = (
        clock_ms[at if order is None else order[at]] * 1000 for at in (boots.first, boots.end - 1)
    )
    gap_us = _stamp_gaps_us(positions.stamp_us[boots.first[1:] - 1], positions.stamp_us[boots.first[1:]])
    shift_us = np.concatenate([[0], np.cumsum(last_us[:-1] + gap_us - first_us[1:])])
    shift_us -= shift_us[boot[vehicles.first]].repeat(np.diff(boot[vehicles.first], append=len(boots.first)))
    clock_ms *= 1000
    clock_ms += shift_us[boot]
    return BootClock(clock_ms / 1e6, boot, order)


def plausible_utc_s(stamp_us: int) -> float | None:
    """A log stamp as Unix time, None where it cannot be right."""
    return stamp_us / 1e6 if _EARLIEST_STAMP_US < stamp_us < _LATEST_STAMP_US else None


class _Runs:
    """Runs of ``n`` records: each goes from its ``first`` to before its ``end``, both (m,)."""

    def __init__(self, first: Indices, n: int) -> None:
        self.first = first
        self.end = np.append(first[1:], n)

    def spread(self, values: NDArray[Number]) -> NDArray[Number]:
        """A value of each run (m,) for each of its records (n,)."""
        return np.repeat(values, self.end - self.first)

    def end_of(self, index: Indices) -> Indices:
        """The end of the run that each record (k,) is in."""
        return self.end[np.searchsorted(self.first, index, "right") - 1]

    def cumulated(self, steps: Integers) -> Integers:
        """The sum of the steps (n - 1,) between records up to each record (n,), from 0 in each run."""
        total = np.concatenate([[0], np.cumsum(steps)])
        return np.asarray(total - self.spread(total[self.first]))


def _running_ms(positions: Positions, vehicles: _Runs) -> Integers:
    """Clocks (n,), moved by the stamps where a vehicle's stands still, as that of senders without one."""
    time_ms = positions.time_ms.astype(np.int64)
    if (time_ms[vehicles.first] == time_ms[vehicles.end - 1]).any():
        stands = np.logical_and.reduceat(time_ms == vehicles.spread(time_ms[vehicles.first]), vehicles.first)
        gaps_us = _stamp_gaps_us(positions.stamp_us[:-1], positions.stamp_us[1:])
        time_ms += vehicles.cumulated(gaps_us) // 1000 * vehicles.spread(stands)
    return time_ms


def _unwrapped(time_ms: Integers, vehicles: _Runs) -> Integers:
    """The counters as if they had more bits, shape (n,)."""
    step = np.diff(time_ms)
    most = _WRAP_MS - _WRAP_GAP_MS
    turns = (step < -most).astype(np.int64) - (step > most)
    return time_ms + _WRAP_MS * vehicles.cumulated(turns) if turns.any() else time_ms


def _is_late(clock_ms: Integers, falls: Indices, end: Indices) -> Flags:
    """Which falls (m,) of clocks mean that records come late, not that the vehicle booted.

    After late records the clock leaps back to where it was; a rebooted one has to run there.

    Args:
        clock_ms: Clocks (n,).
        falls: Indices of records.
        end: Where the records of the same vehicle end.
    """
    late = np.zeros(len(falls), np.bool_)
    before = clock_ms[falls - 1]
    half_way = (before + clock_ms[falls]) // 2
    waiting = np.arange(len(falls))
    for row in range(1, _LATE_ROWS + 1):
        waiting = waiting[falls[waiting] + row < end[waiting]]
        now = clock_ms[falls[waiting] + row]
        late[waiting[now >= before[waiting]]] = True
        waiting = waiting[now <= half_way[waiting]]
    return late


def _stamp_gaps_us(before_us: Integers, after_us: Integers) -> Integers:
    """Microseconds between log stamps (m,), 0 where they cannot be right."""
    plausible = (before_us > _EARLIEST_STAMP_US) & (before_us <= after_us) & (after_us < _LATEST_STAMP_US)
    gaps_us = np.where(plausible, after_us - before_us, 0)
    return np.where(gaps_us <= _LONGEST_REBOOT_US, gaps_us, 0)

"""The vehicle's clock: ``time_boot_ms`` carried on over wraps and reboots, so that time never falls.

A falling clock is a reboot, but for two kinds of falls: the 32-bit counter wraps after 49.7 days,
and records come late (``late_records.py``). Log stamps, which are often wrong, only say whether a
vehicle can have booted, how long that took, and how time went on for a vehicle whose clock stands
still, and only if they can be right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats, Indices, Integers
from flight_replay.geometry.geodesy import distance_m
from flight_replay.logs.plausibility import FASTEST_M_S
from flight_replay.logs.tlog.clock import stamps
from flight_replay.logs.tlog.clock.late_records import are_late
from flight_replay.logs.tlog.clock.record_runs import Runs
from flight_replay.logs.tlog.columns import Positions

_WRAP_MS = 1 << 32
_WRAP_GAP_MS = 3_600_000  # a fall by nearly a whole turn is a wrap if no more than this is missing

_APPENDED_US = 600_000_000  # no recorder is off by so much between two records
_NEAR_M = 1000.0
_LONGEST_STEP_US = 86_400_000_000  # beyond a day, stamps say nothing about one flight


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
    vehicles = Runs(np.flatnonzero(np.diff(positions.vehicle, prepend=-1)), len(positions))
    clock_ms = _unwrapped(_running_ms(positions, vehicles), vehicles)
    falls = np.flatnonzero(clock_ms[1:] < clock_ms[:-1]) + 1
    falls = falls[~np.isin(falls, vehicles.first)]
    reboots = falls[~are_late(clock_ms, positions.stamp_us, falls, vehicles)]
    begins = np.concatenate([vehicles.first, reboots, _appended(positions, clock_ms)])
    boots = Runs(np.unique(begins), len(positions))
    boot = boots.spread(np.arange(len(boots.first), dtype=np.int32))
    order = np.lexsort((clock_ms, boot)) if len(falls) > len(reboots) else None
    first_us, last_us = (
        clock_ms[at if order is None else order[at]] * 1000 for at in (boots.first, boots.end - 1)
    )
    gap_us = stamps.gaps_us(positions.stamp_us[boots.first[1:] - 1], positions.stamp_us[boots.first[1:]])
    shift_us = np.concatenate([[0], np.cumsum(last_us[:-1] + gap_us - first_us[1:])])
    shift_us -= shift_us[boot[vehicles.first]].repeat(np.diff(boot[vehicles.first], append=len(boots.first)))
    clock_ms *= 1000
    clock_ms += shift_us[boot]
    return BootClock(clock_ms / 1e6, boot, order)


def _appended(positions: Positions, clock_ms: Integers) -> Indices:
    """The records (k,) that another log begins with which was appended, its clock higher by chance.

    Stamps alone do not tell: the recorder's clock may have been set. The vehicle is also where it cannot have
    flown to by its own clock.
    """
    counted_us = np.diff(clock_ms) * 1000
    missing_us = stamps.steps_us(positions.stamp_us[:-1], positions.stamp_us[1:]) - counted_us
    before = np.flatnonzero((np.abs(missing_us) > _APPENDED_US) & (counted_us >= 0))
    here, there = ((positions.lat_e7[at] / 1e7, positions.lon_e7[at] / 1e7) for at in (before, before + 1))
    apart_m = distance_m(*here, *there)
    return np.asarray(before[apart_m > _NEAR_M + FASTEST_M_S * counted_us[before] / 1e6] + 1)


def _running_ms(positions: Positions, vehicles: Runs) -> Integers:
    """Clocks (n,), moved by the stamps where a vehicle's stands still, as that of senders without one."""
    time_ms = positions.time_ms.astype(np.int64)
    if (time_ms[vehicles.first] == time_ms[vehicles.end - 1]).any():
        stands = np.logical_and.reduceat(time_ms == vehicles.spread(time_ms[vehicles.first]), vehicles.first)
        gaps_us = stamps.gaps_us(positions.stamp_us[:-1], positions.stamp_us[1:])
        gaps_us[gaps_us > _LONGEST_STEP_US] = 0
        time_ms += vehicles.cumulated(gaps_us) // 1000 * vehicles.spread(stands)
    return time_ms


def _unwrapped(time_ms: Integers, vehicles: Runs) -> Integers:
    """The counters as if they had more bits, shape (n,)."""
    step = np.diff(time_ms)
    most = _WRAP_MS - _WRAP_GAP_MS
    turns = (step < -most).astype(np.int64) - (step > most)
    return time_ms + _WRAP_MS * vehicles.cumulated(turns) if turns.any() else time_ms

"""The sections of a DataFlash log: what was written between two starts of the autopilot, or of the logger.

A section begins where FMT is defined anew, as at the beginning of every log, or where time falls by
more than a second. A single record whose time fits neither the one before nor the one behind is damaged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Flags, Floats, Indices, Integers
from flight_replay.logs.dataflash.message_rows import Offsets
from flight_replay.logs.dataflash.message_tables import GpsPositions, LoggedColumns

_FALL_S = 1.0
MOST_SECTIONS = 4096
"""More starts than any log holds."""


@dataclass(frozen=True, slots=True, eq=False)
class LogSections:
    """Where sections begin after the first (m,), and records with a damaged time (k,), as offsets."""

    begin: Offsets
    damaged: Offsets

    def of(self, offset: Offsets) -> Indices:
        """The section of each record (n,), from 0."""
        return np.searchsorted(self.begin, offset, "right")

    def are_damaged(self, records: LoggedColumns) -> Flags:
        """Which records (n,) have a time that cannot be right, or none."""
        return np.isnan(records.time_s) | np.isin(records.offset, self.damaged)


def find_sections(name: str, tables: Sequence[LoggedColumns], restarts: Sequence[int]) -> LogSections:
    """The sections of a log.

    Args:
        name: The log's name.
        tables: Records, those of each table with times that should not fall within a section. A receiver's
            may be older than those of other tables.
        restarts: Offsets at which FMT is defined.

    Raises:
        LogError: There are more than any log can have.
    """
    known = np.array(restarts[1:] if restarts[:1] == [0] else restarts, np.int64)
    damaged, falls = zip(*(_damaged_and_falls(table) for table in tables), strict=True)
    before, behind = np.concatenate(falls, axis=1)
    unknown = np.searchsorted(known, before, "right") == np.searchsorted(known, behind, "right")
    order = np.argsort(behind[unknown])
    begin = [int(place) for place in known]
    last = -1
    for start, end in zip(before[unknown][order].tolist(), behind[unknown][order].tolist(), strict=True):
        if last <= start:  # else the clock of another table fell here too
            begin.append(last := end)
    if len(begin) > MOST_SECTIONS:
        raise LogError(
            f"the times in {name} fall {len(begin)} times, as if it were written in as many parts; it is "
            "damaged or no log of a flight, name another one"
        )
    return LogSections(np.unique(np.array(begin, np.int64)), np.concatenate(damaged))


def _damaged_and_falls(table: LoggedColumns) -> tuple[Offsets, NDArray[np.int64]]:
    """Records with a damaged time (k,), and between which records the clock falls (2, m), as offsets."""
    offset, time_s = table.offset[~np.isnan(table.time_s)], table.time_s[~np.isnan(table.time_s)]
    is_outlier = _outliers(time_s)
    damaged, offset, time_s = offset[is_outlier], offset[~is_outlier], time_s[~is_outlier]
    falls = np.flatnonzero(np.diff(time_s) < -_FALL_S)
    return damaged, np.stack([offset[falls], offset[falls + 1]])


def _outliers(time_s: Floats) -> Flags:
    """Which of the times (n,), in the order of the log, fit neither the one before nor the one behind."""
    found = np.zeros(len(time_s), np.bool_)
    if len(time_s) < 3:
        return found
    before = np.r_[-np.inf, time_s[:-1]]
    behind = np.r_[time_s[1:], np.inf]
    fits_around = before <= behind + _FALL_S
    found = fits_around & ((time_s > behind + _FALL_S) | (time_s < before - _FALL_S))
    # Of two neighbours of which each would fit without the other, the first is taken for the damaged one.
    found[1:] &= ~found[:-1]
    return np.asarray(found)


@dataclass(frozen=True, slots=True, eq=False)
class SectionClocks:
    """The clocks of sections in a row: ``shift_s`` (m,) makes one of them all.

    ``utc_s`` (m,) is Unix time at their zero, not a number where no receiver told.
    """

    shift_s: Floats
    utc_s: Floats


def joined_clocks(
    section: Integers, time_s: Floats, gps: GpsPositions, gps_section: Indices
) -> SectionClocks:
    """One clock of those of the sections; the first one's is kept.

    The time between two sections is that of the receiver; where it is not known, a clock that does not
    fall goes on, and one that falls begins where the last one ended.

    Args:
        section: The section of each position (n,), numbered from 0 without gaps, not falling.
        time_s: Their times (n,), not falling within a section.
        gps: What the receivers told.
        gps_section: The section of each of these records, numbered likewise, others being -1.
    """
    first = np.append(0, np.flatnonzero(section[1:] != section[:-1]) + 1)
    first_s, last_s = time_s[first], time_s[np.append(first[1:], len(section)) - 1]
    utc_s = _utc_at_zero_s(len(first), gps, gps_section)
    gap_s = (utc_s + first_s)[1:] - (utc_s + last_s)[:-1]
    clock_gap_s = np.maximum(first_s[1:] - last_s[:-1], 0.0)
    gap_s = np.where(gap_s >= 0, gap_s, clock_gap_s)
    shift_s = np.r_[0.0, np.cumsum(last_s[:-1] + gap_s - first_s[1:])]
    return SectionClocks(shift_s, utc_s)


def _utc_at_zero_s(n: int, gps: GpsPositions, section: Integers) -> Floats:
    """Unix time at zero of each section's clock (n,): the median of what its receivers told."""
    is_known = gps.has_3d_fix & ~np.isnan(gps.utc_s) & ~np.isnan(gps.time_s) & (section >= 0)
    section, zero_s = section[is_known], (gps.utc_s - gps.time_s)[is_known]
    order = np.lexsort((zero_s, section))
    firsts = np.searchsorted(section[order], np.arange(n + 1))
    counts = np.diff(firsts)
    middles = np.minimum(firsts[:-1] + counts // 2, max(len(order) - 1, 0))
    utc_s = np.full(n, np.nan)
    if len(order):
        utc_s[counts > 0] = zero_s[order][middles[counts > 0]]
    return utc_s

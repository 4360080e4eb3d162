"""Log stamps: microseconds since 1970 by the clock of whatever recorded the log, right or wrong."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Flags, Integers

_EARLIEST_US = 946_684_800_000_000  # 2000, before there was MAVLink
_LATEST_US = 4_102_444_800_000_000  # 2100


def plausible_utc_s(stamp_us: int) -> float | None:
    """A log stamp as Unix time, None where it cannot be right."""
    return stamp_us / 1e6 if _EARLIEST_US < stamp_us < _LATEST_US else None


def in_order(before_us: Integers, after_us: Integers) -> Flags:
    """Which pairs of stamps (m,) can be right, and do not fall."""
    return np.asarray((before_us > _EARLIEST_US) & (before_us <= after_us) & (after_us < _LATEST_US))


def steps_us(before_us: Integers, after_us: Integers) -> Integers:
    """Microseconds from stamp to stamp (m,), which may fall; 0 where one of them cannot be right."""
    least, most = np.minimum(before_us, after_us), np.maximum(before_us, after_us)
    return np.where(in_order(least, most), after_us - before_us, 0)


def gaps_us(before_us: Integers, after_us: Integers) -> Integers:
    """Microseconds between log stamps (m,), 0 where they cannot be right."""
    return np.where(in_order(before_us, after_us), after_us - before_us, 0)

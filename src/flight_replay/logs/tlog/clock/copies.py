"""Positions that are in a log twice, as two links brought them."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from flight_replay.geometry.arrays import Indices
from flight_replay.logs.tlog.clock.boot_clock import BootClock
from flight_replay.logs.tlog.columns import Positions

_OWN = {"offset", "stamp_us"}  # what a copy has of its own


def copies(positions: Positions, clock: BootClock) -> Indices:
    """The positions (m,) that say nothing but what the one before, in the order of time, says.

    Senders without a clock say 0 for the time: theirs may be alike because the vehicle stands.
    """
    time_s = clock.time_s if clock.order is None else clock.time_s[clock.order]
    second = np.flatnonzero(time_s[1:] == time_s[:-1]) + 1
    first = second - 1
    if clock.order is not None:
        first, second = clock.order[first], clock.order[second]
    alike = positions.time_ms[second] > 0
    for column in (getattr(positions, each.name) for each in fields(positions) if each.name not in _OWN):
        alike &= column[first] == column[second]
    return np.asarray(second[alike])

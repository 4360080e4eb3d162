"""Which falls of vehicles' clocks mean that records come late, not that a vehicle booted.

Datagrams overtake each other, and a log of two links to one vehicle holds the later one's records behind
those of the other: alternately, in bursts, or all that a stalled link kept back, at once.
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats, Indices, Integers
from flight_replay.logs.tlog.clock import stamps
from flight_replay.logs.tlog.clock.record_runs import Runs

LONGEST_LAG_S = 600.0
"""No link keeps records back for longer: what is older is of another vehicle, or another clock."""
_COUNTER_BITS = (1 << 32) - 1  # of clocks: whether they went round before a boot cannot be told
_LATE_ROWS = 16  # how many records may arrive late in a row where stamps do not help
_LEAST_SHARE, _SLACK_US = 0.5, 1e6  # of the time since a boot, that stamps at least show: they are late, too
_LAG_ROWS, _LEAST_SPAN_US = 1000, 500_000  # over which a pace is measured: a burst has none
_MOST_PAIRS = 1000  # of records of a run, that its pace is the median of


def are_late(clock_ms: Integers, stamp_us: Integers, falls: Indices, vehicles: Runs) -> Flags:
    """Which falls (m,) of clocks mean that records come late, not that the vehicle booted.

    Args:
        clock_ms: Clocks (n,).
        stamp_us: Log stamps (n,).
        falls: Indices of records.
        vehicles: The records of each vehicle.
    """
    late = _leap_back(clock_ms, falls, vehicles.end[vehicles.of(falls)])
    left = np.flatnonzero(~late)
    if len(left):
        late[left] = _come_too_soon(clock_ms, stamp_us, falls[left], vehicles)
    return late


def _leap_back(clock_ms: Integers, falls: Indices, end: Indices) -> Flags:
    """After which falls (m,) clocks soon leap back to where they were; a rebooted one has to run there.

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


def _come_too_soon(clock_ms: Integers, stamp_us: Integers, falls: Indices, vehicles: Runs) -> Flags:
    """After which falls (m,) clocks show more time since a boot than has passed since the record before.

    Simulators run faster than the stamps, so time passes at the pace of the clock that fell. Nothing is
    said where stamps do not tell: where they fall, cannot be right, or stand still all along.

    Args: as ``are_late``.
    """
    now_ms, before_ms = clock_ms[falls], clock_ms[falls - 1]
    before_us, after_us = stamp_us[falls - 1], stamp_us[falls]
    passed_us = after_us - before_us
    least_us = _LEAST_SHARE * 1e3 * (now_ms & _COUNTER_BITS) - _SLACK_US
    is_too_soon = stamps.in_order(before_us, after_us) & (passed_us < least_us)
    is_too_soon &= before_ms - now_ms <= 1e3 * LONGEST_LAG_S
    some = np.flatnonzero(is_too_soon)
    if len(some):
        deep = falls[now_ms < before_ms // 2]  # where a boot may begin that has a pace of its own
        runs = Runs(np.union1d(vehicles.first, deep), len(clock_ms))
        its, run = np.unique(runs.of(falls[some]), return_inverse=True)
        pace = np.maximum(_paces(clock_ms, stamp_us, runs.first[its], runs.end[its]), 1.0)[run]
        is_too_soon[some] = pace * passed_us[some] < least_us[some]  # not if the pace is not a number
    return is_too_soon


def _paces(clock_ms: Integers, stamp_us: Integers, first: Indices, end: Indices) -> Floats:
    """How fast clocks run by the stamps in runs of records, shape (m,); not a number where that is unknown.

    The median over a run of steps of many rows, in which what comes late or at once counts for little.

    Args:
        clock_ms: Clocks (n,).
        stamp_us: Log stamps (n,).
        first: Where the runs begin (m,).
        end: Where they end (m,).
    """
    rows = np.clip((end - first) // 4, 1, _LAG_ROWS)
    steps = end - first - rows
    count = np.minimum(steps, _MOST_PAIRS)
    run = np.repeat(np.arange(len(first)), count)
    nth = np.arange(len(run)) - np.repeat(np.cumsum(count) - count, count)
    begin = first[run] + nth * steps[run] // count[run]
    stop = begin + rows[run]
    passed_ms, passed_us = clock_ms[stop] - clock_ms[begin], stamp_us[stop] - stamp_us[begin]
    tell = stamps.in_order(stamp_us[begin], stamp_us[stop]) & (passed_us >= _LEAST_SPAN_US) & (passed_ms > 0)
    run, pace = run[tell], 1e3 * passed_ms[tell] / passed_us[tell]
    pace = pace[np.lexsort((pace, run))]
    count = np.bincount(run, minlength=len(first))
    known = np.flatnonzero(count)
    paces = np.full(len(first), np.nan)
    paces[known] = pace[(np.cumsum(count) - count + count // 2)[known]]
    return paces

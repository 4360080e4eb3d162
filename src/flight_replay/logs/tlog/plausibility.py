"""Which positions of a vehicle are plausible, and why the others are not.

Rules, the first that applies: the receiver said that it had no 3D fix; within a hair of 0, 0,
where estimators begin without one; not on the globe; a jump that neither the velocity that
the vehicle itself reported nor any multicopter's speed can explain.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from math import dist

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.geometry.geodesy import surface_xyz_m
from flight_replay.logs.tlog.boot_clock import BootClock
from flight_replay.logs.tlog.columns import Fixes, Positions


class Verdict(IntEnum):
    """What is held against a position; an empty one is no position at all."""

    NONE = 0
    EMPTY = 1
    NO_FIX = 2
    NEAR_ZERO = 3
    OUTSIDE = 4
    JUMP = 5


REASONS = {
    Verdict.NO_FIX: "no 3D fix",
    Verdict.NEAR_ZERO: "near 0,0",
    Verdict.OUTSIDE: "outside the globe",
    Verdict.JUMP: "impossible jump",
}

_HAIR_E7 = 200_000  # 0.02 degrees, 2.2 km: positions without a fix were seen 0.01 degrees from 0, 0
_QUARTER_TURN_E7 = 900_000_000
_HALF_TURN_E7 = 1_800_000_000
_REPORTED_S = 10.0  # how long a receiver's last word of all holds
_FASTEST_M_S = 60.0  # multicopters beyond this are built for records, and report their speed
_VELOCITY_FACTOR = 1.5  # between two records a vehicle may have been faster than at either
_SLACK_M = 20.0  # estimators correct themselves by metres at once
_SLACK_E7 = 1_200  # both ways less than that: 1e-7 degrees are 11.2 mm at most
_LOOK_BACK = 8  # how many runs of positions before it a run may follow


def judge(positions: Positions, fixes: Fixes, clock: BootClock) -> NDArray[np.int8]:
    """The verdict on each position (n,) of one vehicle, in the order of the log."""
    lat, lon = positions.lat_e7, positions.lon_e7
    verdict = np.zeros(len(positions), np.int8)
    verdict[_beyond(lat, _QUARTER_TURN_E7) | _beyond(lon, _HALF_TURN_E7)] = Verdict.OUTSIDE
    verdict[~_beyond(lat, _HAIR_E7) & ~_beyond(lon, _HAIR_E7)] = Verdict.NEAR_ZERO
    verdict[_without_fix(positions, fixes, clock)] = Verdict.NO_FIX
    verdict[positions.is_empty] = Verdict.EMPTY
    left = clock.in_order(verdict == Verdict.NONE)
    verdict[left[_wrong_side_of_jumps(positions, clock, left)]] = Verdict.JUMP
    return verdict


def _beyond(value: NDArray[np.int32], limit: int) -> Flags:
    """Where an angle is more than ``limit`` from 0; the lowest integer has no absolute value."""
    return (value > limit) | (value < -limit)


def _without_fix(positions: Positions, fixes: Fixes, clock: BootClock) -> Flags:
    """Where the receiver's last word before the position was less than a 3D fix.

    A word holds until the next one; the last of the log for a while only, counted from the
    position that follows it, because some logs tell of the receiver just once.
    """
    lost = ~fixes.is_3d
    begins = np.flatnonzero(lost & ~np.concatenate([[False], lost[:-1]]))
    if not len(begins):
        return np.zeros(len(positions), np.bool_)
    ends = np.flatnonzero(lost & ~np.concatenate([lost[1:], [False]])) + 1
    following = np.append(np.searchsorted(positions.offset, fixes.offset), len(positions))
    if lost[-1]:
        time_s = np.maximum.accumulate(clock.time_s)
        reported_s = np.append(time_s, np.inf)[following[-2]] + _REPORTED_S
        following[-1] = np.searchsorted(time_s, reported_s, "right")
    changes = np.zeros(len(positions) + 1, np.int32)
    np.add.at(changes, following[begins], 1)
    np.add.at(changes, following[ends], -1)
    return np.cumsum(changes[:-1]) > 0


def _wrong_side_of_jumps(positions: Positions, clock: BootClock, left: Indices) -> Flags:
    """Which of the positions ``left`` (m,), in order of time, lie on the wrong side of an impossible jump.

    Jumps cut each boot into runs. Of all chains of runs that can follow each other, the one with
    most positions is plausible: an outlier is left out, and so is a false start before a jump.
    """
    boot = clock.boot[left]
    is_far = boot[1:] == boot[:-1]
    is_far &= _is_step(positions.lat_e7[left]) | _is_step(positions.lon_e7[left])
    far = np.flatnonzero(is_far)
    possible = _possible(_ends(positions, clock, left[far]), _ends(positions, clock, left[far + 1]))
    runs = _runs(boot, far[~possible] + 1)
    wrong = np.zeros(len(left) + 1, np.int8)
    if len(runs.first):
        starts, ends = (_ends(positions, clock, left[index]) for index in (runs.first, runs.last))
        implausible = ~_plausible_runs(runs, starts, ends)
        wrong[runs.first[implausible]] += 1
        wrong[runs.last[implausible] + 1] -= 1
    return np.cumsum(wrong[:-1]) > 0


@dataclass(frozen=True, slots=True, eq=False)
class _Runs:
    """Positions in a row without a jump, of boots that have jumps: ``first`` to ``last`` of ``boot`` (m,)."""

    first: Indices
    last: Indices
    boot: Indices


def _runs(boot: NDArray[np.int32], cuts: Indices) -> _Runs:
    """The runs that begin at ``cuts``, and those before them.

    Args:
        boot: The boot of each position (n,), ascending.
        cuts: Positions that a jump leads to, ascending.
    """
    bounds = np.concatenate([[0], np.flatnonzero(np.diff(boot)) + 1, [len(boot)]])
    has_cut = np.diff(np.searchsorted(cuts, bounds)) > 0
    first = np.sort(np.concatenate([bounds[:-1][has_cut], cuts]))
    number = np.searchsorted(bounds, first, "right") - 1
    last = np.minimum(np.append(first[1:], len(boot)), bounds[number + 1]) - 1
    return _Runs(first, last, number)


def _is_step(angle_e7: NDArray[np.int32]) -> Flags:
    """Where an angle (n,) changes by so much that it may be a jump, shape (n - 1,)."""
    return _beyond(np.diff(angle_e7), _SLACK_E7)


@dataclass(frozen=True, slots=True, eq=False)
class _Ends:
    """Where runs start or end: places (m, 3) in metres, times, and the speeds that they are trusted with."""

    xyz_m: Floats
    time_s: Floats
    fastest_m_s: Floats

    def select(self, keep: slice) -> _Ends:
        return _Ends(self.xyz_m[keep], self.time_s[keep], self.fastest_m_s[keep])


def _ends(positions: Positions, clock: BootClock, index: Indices) -> _Ends:
    """The positions of an index array (m,)."""
    xyz_m = surface_xyz_m(positions.lat_e7[index] / 1e7, positions.lon_e7[index] / 1e7)
    columns = positions.north_cm_s, positions.east_cm_s, positions.down_cm_s
    squares = sum(column[index].astype(float) ** 2 for column in columns)
    reported_m_s = _VELOCITY_FACTOR * np.sqrt(squares) / 100
    return _Ends(xyz_m, clock.time_s[index], np.maximum(reported_m_s, _FASTEST_M_S))


def _possible(start: _Ends, end: _Ends) -> Flags:
    """Whether the vehicle can have moved from each start to its end (m,)."""
    apart_m = np.linalg.norm(end.xyz_m - start.xyz_m, axis=1)
    fastest_m_s = np.maximum(start.fastest_m_s, end.fastest_m_s)
    return np.asarray(apart_m <= _SLACK_M + fastest_m_s * (end.time_s - start.time_s))


def _plausible_runs(runs: _Runs, starts: _Ends, ends: _Ends) -> Flags:
    """Which runs (m,) are in the heaviest chain of their boot.

    Looks back at the last few runs and at the end of the heaviest chain so far, so that time does
    not grow with the square of the number of runs. No call of numpy for each run: there may be a million.
    """
    earlier = _followed(runs, starts, ends).tolist()
    can_move = _scalar_possible(starts, ends)
    boots = runs.boot.tolist()
    weights = (runs.last - runs.first + 1).tolist()
    before = [-1] * len(weights)
    heaviest = 0
    chain_ends = []
    for run in range(1, len(weights)):
        if boots[run] != boots[run - 1]:
            chain_ends.append(heaviest)
            heaviest = run
            continue
        best = heaviest if heaviest < run - _LOOK_BACK and can_move(heaviest, run) else -1
        flags = earlier[run]
        for back in range(_LOOK_BACK, 0, -1) if flags else ():
            if flags >> (back - 1) & 1 and (best < 0 or weights[run - back] > weights[best]):
                best = run - back
        if best >= 0:
            before[run] = best
            weights[run] += weights[best]
        if weights[run] > weights[heaviest]:
            heaviest = run
    return _chains(before, [*chain_ends, heaviest])


def _chains(before: list[int], last: list[int]) -> Flags:
    """Which runs are in the chains that end at the runs ``last``."""
    plausible = np.zeros(len(before), np.bool_)
    for chain_end in last:
        run = chain_end
        while run >= 0:
            plausible[run] = True
            run = before[run]
    return plausible


def _followed(runs: _Runs, starts: _Ends, ends: _Ends) -> NDArray[np.uint8]:
    """Which of the runs before each run (m,) it may follow: bit 0 is the one before it, and so on."""
    flags = np.zeros(len(runs.first), np.uint8)
    for back in range(1, min(_LOOK_BACK, len(flags) - 1) + 1):
        possible = _possible(ends.select(slice(None, -back)), starts.select(slice(back, None)))
        possible &= runs.boot[back:] == runs.boot[:-back]
        flags[back:] |= possible.astype(np.uint8) << np.uint8(back - 1)
    return flags


def _scalar_possible(starts: _Ends, ends: _Ends) -> Callable[[int, int], bool]:
    """``_possible`` from the end of one run to the start of another, for single runs."""
    start_xyz_m, end_xyz_m = starts.xyz_m.tolist(), ends.xyz_m.tolist()
    start_s, end_s = starts.time_s.tolist(), ends.time_s.tolist()
    start_m_s, end_m_s = starts.fastest_m_s.tolist(), ends.fastest_m_s.tolist()

    def possible(earlier: int, later: int) -> bool:
        fastest_m_s = max(end_m_s[earlier], start_m_s[later])
        reach_m = _SLACK_M + fastest_m_s * (start_s[later] - end_s[earlier])
        return bool(dist(end_xyz_m[earlier], start_xyz_m[later]) <= reach_m)

    return possible

"""Which positions of a vehicle can be believed, and why the others cannot.

Rules, the first that applies: the receiver said that it had no 3D fix; within a hair of 0, 0,
where estimators begin without one; not on the globe; a jump that neither the velocity that
the vehicle itself reported nor any multicopter's speed can explain.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.geometry.geodesy import distance_m
from flight_replay.logs.tlog.boot_clock import Clock
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
_TOLD_S = 10.0  # how long a receiver's last word of all holds
_FASTEST_M_S = 60.0  # multicopters beyond this are built for records, and report their speed
_VELOCITY_FACTOR = 1.5  # between two records a vehicle may have been faster than at either
_SLACK_M = 20.0  # estimators correct themselves by metres at once
_SLACK_E7 = 1_200  # both ways less than that: 1e-7 degrees are 11.2 mm at most
_LOOK_BACK = 8  # how many runs of positions before it a run may follow


def judge(positions: Positions, fixes: Fixes, clock: Clock) -> NDArray[np.int8]:
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


def _without_fix(positions: Positions, fixes: Fixes, clock: Clock) -> Flags:
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
        told_s = np.append(time_s, np.inf)[following[-2]] + _TOLD_S
        following[-1] = np.searchsorted(time_s, told_s, "right")
    changes = np.zeros(len(positions) + 1, np.int32)
    np.add.at(changes, following[begins], 1)
    np.add.at(changes, following[ends], -1)
    return np.cumsum(changes[:-1]) > 0


def _wrong_side_of_jumps(positions: Positions, clock: Clock, left: Indices) -> Flags:
    """Which of the positions ``left`` (m,), in order of time, lie on the wrong side of an impossible jump.

    Jumps cut each boot into runs. Of all chains of runs that can follow each other, the one with
    most positions is believed: an outlier is left out, and so is a false start before a jump.
    """
    wrong = np.zeros(len(left), np.bool_)
    boot = clock.boot[left]
    is_far = boot[1:] == boot[:-1]
    is_far &= _is_step(positions.lat_e7[left]) | _is_step(positions.lon_e7[left])
    moves = _Moves(positions, clock.time_s, left)
    far = np.flatnonzero(is_far)
    cuts = far[~moves.possible(far, far + 1)] + 1
    for jumped in np.flatnonzero(np.bincount(boot[cuts])):
        begin, end = np.searchsorted(boot, [jumped, jumped + 1])
        firsts = np.concatenate([[begin], cuts[(cuts > begin) & (cuts < end)]])
        lasts = np.append(firsts[1:], end) - 1
        for run in _disbelieved(moves, firsts, lasts):
            wrong[firsts[run] : lasts[run] + 1] = True
    return wrong


def _is_step(angle_e7: NDArray[np.int32]) -> Flags:
    """Where an angle (n,) changes by so much that it may be a jump, shape (n - 1,)."""
    return _beyond(np.diff(angle_e7), _SLACK_E7)


class _Moves:
    """Which moves between the positions ``left`` of a vehicle are possible."""

    def __init__(self, positions: Positions, time_s: Floats, left: Indices) -> None:
        self._positions, self._time_s, self._left = positions, time_s, left

    def possible(self, start: Indices, end: Indices) -> Flags:
        """Whether the vehicle can have moved from position ``start`` to ``end``, both (m,)."""
        start, end = self._left[start], self._left[end]
        lat, lon = self._positions.lat_e7, self._positions.lon_e7
        apart_m = distance_m(lat[start] / 1e7, lon[start] / 1e7, lat[end] / 1e7, lon[end] / 1e7)
        fastest_m_s = np.maximum(np.maximum(self._reported_m_s(start), self._reported_m_s(end)), _FASTEST_M_S)
        return np.asarray(apart_m <= _SLACK_M + fastest_m_s * (self._time_s[end] - self._time_s[start]))

    def _reported_m_s(self, index: Indices) -> Floats:
        """The most that a vehicle which reports these velocities is trusted with."""
        columns = self._positions.north_cm_s, self._positions.east_cm_s, self._positions.down_cm_s
        squares = sum(column[index].astype(float) ** 2 for column in columns)
        return np.asarray(_VELOCITY_FACTOR * np.sqrt(squares) / 100)


def _disbelieved(moves: _Moves, firsts: Indices, lasts: Indices) -> set[int]:
    """The runs, from ``firsts`` to ``lasts`` (m,), that are not in the heaviest chain.

    Looks back at the last few runs and at the end of the heaviest chain so far, so that time does
    not grow with the square of the number of runs.
    """
    may_follow = _may_follow(moves, firsts, lasts)
    weights = (lasts - firsts + 1).tolist()
    before = [-1] * len(weights)
    heaviest = 0
    for run in range(1, len(weights)):
        earlier = [run - back for back in range(_LOOK_BACK, 0, -1) if may_follow[back - 1][run]]
        if heaviest < run - _LOOK_BACK and moves.possible(lasts[[heaviest]], firsts[[run]]).all():
            earlier.insert(0, heaviest)
        if earlier:
            before[run] = max(earlier, key=weights.__getitem__)
            weights[run] += weights[before[run]]
        if weights[run] > weights[heaviest]:
            heaviest = run
    chain = set()
    while heaviest >= 0:
        chain.add(heaviest)
        heaviest = before[heaviest]
    return set(range(len(weights))) - chain


def _may_follow(moves: _Moves, firsts: Indices, lasts: Indices) -> list[list[bool]]:
    """Whether a run may follow the one before it, the second before it and so on: a row (m,) each."""
    rows = np.zeros((_LOOK_BACK, len(firsts)), np.bool_)
    for back in range(1, min(_LOOK_BACK, len(firsts) - 1) + 1):
        rows[back - 1, back:] = moves.possible(lasts[:-back], firsts[back:])
    rows_listed: list[list[bool]] = rows.tolist()
    return rows_listed

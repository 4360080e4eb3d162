"""Which positions of a vehicle can be believed, and why the others cannot.

Rules, the first that applies: the receiver said that it had no 3D fix; within a hair of 0, 0,
where estimators begin without one; not on the globe; a jump that neither the velocity that
the vehicle itself reported nor any multicopter's speed can explain.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from flight_replay.geodesy import Floats, surface_xyz_m
from flight_replay.tlog.columns import Table

Flags = NDArray[np.bool_]


class Verdict(IntEnum):
    """What is held against a position; empty ones are no positions at all."""

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
_FASTEST_M_S = 60.0  # multicopters beyond this are built for records, and report their speed
_VELOCITY_FACTOR = 1.5  # between two records a vehicle may have been faster than at either
_SLACK_M = 20.0  # estimators correct themselves by metres at once
_TOLD_S = 10.0  # how long a receiver's last word holds
_LOOK_BACK = 8  # runs of positions that a run may follow


def judge(positions: Table, fixes: Table, time_s: Floats, section: NDArray[np.int32]) -> NDArray[np.int8]:
    """The verdict on each position (n,) of one vehicle, in order of time."""
    verdict = np.zeros(len(positions), np.int8)
    lat, lon = positions["lat_e7"], positions["lon_e7"]
    near_zero = (np.abs(lat) <= _HAIR_E7) & (np.abs(lon) <= _HAIR_E7)
    outside = (lat > 900_000_000) | (lat < -900_000_000) | (lon > 1_800_000_000) | (lon < -1_800_000_000)
    verdict[outside] = Verdict.OUTSIDE
    verdict[near_zero] = Verdict.NEAR_ZERO
    verdict[_without_fix(positions, fixes, time_s)] = Verdict.NO_FIX
    verdict[(lat == 0) & (lon == 0)] = Verdict.EMPTY
    left = np.flatnonzero(verdict == Verdict.NONE)
    verdict[left[_beyond_jumps(positions[left], time_s[left], section[left])]] = Verdict.JUMP
    return verdict


def _without_fix(positions: Table, fixes: Table, time_s: Floats) -> Flags:
    """Where the receiver's last word before the position was less than a 3D fix.

    A word holds until an equal one; else for a while only after the position that follows it.
    """
    if fixes["is_3d"].all():
        return np.zeros(len(positions), np.bool_)
    words = np.searchsorted(fixes["offset"], positions["offset"]) - 1
    following = np.minimum(words + 1, len(fixes) - 1)
    is_lost = (words >= 0) & ~fixes["is_3d"][words]
    in_order = np.argsort(positions["offset"], kind="stable")
    spoken = np.searchsorted(positions["offset"][in_order], fixes["offset"])
    spoken_s = np.append(time_s[in_order], np.inf)[spoken]
    return is_lost & (
        ~fixes["is_3d"][following] & (following > words) | (time_s - spoken_s[words] <= _TOLD_S)
    )


def _beyond_jumps(positions: Table, time_s: Floats, section: NDArray[np.int32]) -> Flags:
    """The positions on the wrong side of impossible jumps.

    Jumps cut each section into runs. Of all chains of runs that can follow each other, the one with
    most positions is believed: an outlier is left out, and so is a false start before a jump.
    """
    wrong = np.zeros(len(positions), np.bool_)
    if len(positions) < 2:
        return wrong
    xyz = surface_xyz_m(positions["lat_e7"] / 1e7, positions["lon_e7"] / 1e7)
    speed = np.sqrt(sum(positions[name].astype(float) ** 2 for name in _VELOCITY)) / 100
    moves = _Moves(xyz, time_s, speed)
    index = np.arange(len(positions))
    cuts = ~moves.possible(index[:-1], index[1:]) & (section[1:] == section[:-1])
    for jumped in np.unique(section[1:][cuts]):
        begin, end = np.searchsorted(section, [jumped, jumped + 1])
        firsts = np.concatenate([[begin], np.flatnonzero(cuts[begin : end - 1]) + begin + 1])
        lasts = np.append(firsts[1:], end) - 1
        for run in _disbelieved(moves, firsts, lasts):
            wrong[firsts[run] : lasts[run] + 1] = True
    return wrong


_VELOCITY = ("north_cm_s", "east_cm_s", "down_cm_s")


class _Moves:
    """Which moves between positions are possible: ``xyz`` (n, 3), times and reported speeds (n,)."""

    def __init__(self, xyz: Floats, time_s: Floats, speed_m_s: Floats) -> None:
        self._xyz, self._time_s, self._speed_m_s = xyz, time_s, speed_m_s

    def possible(self, start: NDArray[np.intp], end: NDArray[np.intp]) -> Flags:
        """Whether the vehicle can have moved from one position to the other."""
        apart_m = np.linalg.norm(self._xyz[end] - self._xyz[start], axis=-1)
        reported_m_s = np.maximum(self._speed_m_s[start], self._speed_m_s[end])
        fastest_m_s = np.maximum(_VELOCITY_FACTOR * reported_m_s, _FASTEST_M_S)
        return np.asarray(apart_m <= _SLACK_M + fastest_m_s * (self._time_s[end] - self._time_s[start]))


def _disbelieved(moves: _Moves, firsts: NDArray[np.intp], lasts: NDArray[np.intp]) -> set[int]:
    """The runs that are not in the heaviest chain.

    Looks back at the last few runs and at the end of the heaviest chain so far, so that time does
    not grow with the square of the number of runs.
    """
    weights = (lasts - firsts + 1).tolist()
    before = [-1] * len(weights)
    heaviest = 0
    for run in range(1, len(weights)):
        earlier = np.array(sorted({*range(max(run - _LOOK_BACK, 0), run), heaviest}))
        possible = earlier[moves.possible(lasts[earlier], np.full(len(earlier), firsts[run]))]
        if len(possible):
            before[run] = max(possible.tolist(), key=weights.__getitem__)
            weights[run] += weights[before[run]]
        if weights[run] > weights[heaviest]:
            heaviest = run
    chain = set()
    while heaviest >= 0:
        chain.add(heaviest)
        heaviest = before[heaviest]
    return set(range(len(weights))) - chain

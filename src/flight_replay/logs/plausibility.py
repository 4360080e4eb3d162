"""Which recorded positions are implausible, and why; for logs of any format.

Rules, of which the first that applies counts: latitude and longitude are both 0, which stands for no
position; the receiver had no 3D fix; the place is next to 0, 0, where estimators begin without one;
it is not on the globe; a jump that neither the velocity that the vehicle itself reported nor any
multicopter's speed can explain.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.geometry.geodesy import surface_xyz_m


class Rejection(IntEnum):
    """Why a position is left out."""

    NONE = 0
    EMPTY = 1
    NO_FIX = 2
    NEAR_ZERO = 3
    OUTSIDE = 4
    JUMP = 5


REASONS = {
    Rejection.NO_FIX: "no 3D fix",
    Rejection.NEAR_ZERO: "near 0,0",
    Rejection.OUTSIDE: "outside the globe",
    Rejection.JUMP: "impossible jump",
}

_NEAR_ZERO_DEG = 0.02  # 2.2 km: positions without a fix were seen 0.01 degrees from 0, 0
FASTEST_M_S = 60.0  # multicopters beyond this are built for records, and report their speed
_VELOCITY_FACTOR = 1.5  # between two records a vehicle may have been faster than at either
_SLACK_M = 20.0  # estimators correct themselves by metres at once
_SLACK_DEG = 1.2e-4  # 13.4 m: with steps below this both ways, the slack is never used up
_LOOK_BACK = 8  # how many runs of positions before it a run may follow
_AT_ONCE = 1 << 16  # positions: what is made of them stays in the cache
_FEWEST_AHEAD, _MOST_AHEAD = 16, 1 << 14  # how many runs ahead are looked at together


def rejected_by_reason(rejection: NDArray[np.int8]) -> dict[str, int]:
    """How many positions, whose ``Rejection`` (n,) is given, are left out for each reason."""
    counts = np.bincount(rejection, minlength=len(Rejection))
    return {reason: int(counts[kind]) for kind, reason in REASONS.items() if counts[kind]}


@dataclass(frozen=True, slots=True, eq=False)
class RecordedPositions:
    """Positions that vehicles recorded, as columns of shape (n,).

    ``speed_m_s_at`` tells the length of the reported velocity at some of them (m,), not a number where
    there was none; ``boot`` numbers what one vehicle's clock counted between two reboots.
    """

    time_s: Floats
    lat_deg: Floats
    lon_deg: Floats
    speed_m_s_at: Callable[[Indices], Floats]
    boot: NDArray[np.int32]
    lacks_3d_fix: Flags

    def places(self, index: Indices) -> Places:
        """Where and when the vehicle was at some positions (m,), and how fast it may have been there."""
        fastest_m_s = np.fmax(_VELOCITY_FACTOR * self.speed_m_s_at(index), FASTEST_M_S)
        xyz_m = surface_xyz_m(self.lat_deg[index], self.lon_deg[index])
        return np.column_stack([self.time_s[index], fastest_m_s, xyz_m])


Places = NDArray[np.float64]
"""Time (s), the most speed that is plausible (m/s), and Earth-centred place (m), shape (m, 5)."""


def find_implausible(positions: RecordedPositions, order: Indices | None = None) -> NDArray[np.int8]:
    """Why each position is rejected, shape (n,), as ``Rejection``.

    Args:
        positions: The positions.
        order: Their indices by boot and time (n,), None if that is the order they are in.
    """
    found = np.zeros(len(positions.lat_deg), np.int8)
    for first in range(0, len(found), _AT_ONCE):
        _judge_places(positions, slice(first, first + _AT_ONCE), found)
    left = np.flatnonzero(found == Rejection.NONE) if order is None else order[found[order] == Rejection.NONE]
    found[left[_beyond_jumps(positions, left)]] = Rejection.JUMP
    return found


def _judge_places(positions: RecordedPositions, part: slice, found: NDArray[np.int8]) -> None:
    """Reject those of a part of the positions that are where no vehicle is; ``found`` (n,) is changed."""
    lat, lon, rejection = np.abs(positions.lat_deg[part]), np.abs(positions.lon_deg[part]), found[part]
    rejection[(lat > 90) | (lon > 180)] = Rejection.OUTSIDE
    rejection[(lat <= _NEAR_ZERO_DEG) & (lon <= _NEAR_ZERO_DEG)] = Rejection.NEAR_ZERO
    rejection[positions.lacks_3d_fix[part]] = Rejection.NO_FIX
    rejection[(lat == 0) & (lon == 0)] = Rejection.EMPTY


def _beyond_jumps(positions: RecordedPositions, left: Indices) -> Flags:
    """Which of the positions ``left`` (m,), by boot and time, are on the wrong side of an impossible jump.

    Jumps cut a boot into runs. Of all chains of runs that can follow each other, the one with most
    positions is kept: an outlier is left out, and so is a false start before a jump.
    """
    boot = positions.boot[left]
    far = np.concatenate(
        [
            _far_steps(positions, left[at : at + _AT_ONCE + 1]) + at
            for at in range(0, max(len(left), 1), _AT_ONCE)
        ]
    )
    can_move = _can_move(positions.places(left[far]), positions.places(left[far + 1]))
    cuts = far[~can_move] + 1
    boots = np.unique(boot[cuts])
    firsts = np.sort(np.append(np.searchsorted(boot, boots), cuts))
    ends = np.sort(np.append(cuts, np.searchsorted(boot, boots, "right")))
    begin, end = positions.places(left[firsts]), positions.places(left[ends - 1])
    is_rejected = ~_in_heaviest_chains(_Runs(ends - firsts, boot[firsts], begin, end))
    steps = np.zeros(len(left) + 1, np.int8)
    steps[firsts[is_rejected]] += 1
    steps[ends[is_rejected]] -= 1
    return np.asarray(np.cumsum(steps[:-1], dtype=np.int8) > 0)


def _far_steps(positions: RecordedPositions, left: Indices) -> Indices:
    """After which of some positions (m,) the next is in the same boot, but not near."""
    boot = positions.boot[left]
    is_far = np.abs(np.diff(positions.lat_deg[left])) > _SLACK_DEG
    is_far |= np.abs(np.diff(positions.lon_deg[left])) > _SLACK_DEG
    is_far &= boot[1:] == boot[:-1]
    return np.flatnonzero(is_far)


def _can_move(start: Places, end: Places) -> Flags:
    """Whether a vehicle can have moved from ``start`` to ``end``, both (m, 5); shape (m,)."""
    apart_m = np.linalg.norm(end[:, 2:] - start[:, 2:], axis=1)
    fastest_m_s = np.maximum(start[:, 1], end[:, 1])
    return np.asarray(apart_m <= _SLACK_M + fastest_m_s * (end[:, 0] - start[:, 0]))


@dataclass(frozen=True, slots=True, eq=False)
class _Runs:
    """Runs of positions between jumps: their number (m,), their boot (m,), their ends in time (m, 5)."""

    length: Indices
    boot: NDArray[np.int32]
    begin: Places
    end: Places

    def follows(self) -> NDArray[np.uint8]:
        """Bit k of each (m,) tells whether the run may follow the one k + 1 before it."""
        follows = np.zeros(len(self.length), np.uint8)
        for back in range(1, min(_LOOK_BACK, len(follows) - 1) + 1):
            may = _can_move(self.end[:-back], self.begin[back:]) & (self.boot[back:] == self.boot[:-back])
            follows[back:] |= may.astype(np.uint8) << (back - 1)
        return follows


def _in_heaviest_chains(runs: _Runs) -> Flags:
    """Which runs (m,) are in that chain of runs, of all in their boot, that has most positions.

    Looks back at the last few runs and at the end of the heaviest chain so far, so that time does
    not grow with the square of the number of runs.
    """
    weights: list[int] = []  # positions in the heaviest chain up to each run
    before: list[int] = []  # the run before it in that chain
    chains: list[int] = []  # the last run of each boot's heaviest chain
    is_first = np.diff(runs.boot, prepend=-1) != 0
    columns = (column.tolist() for column in (runs.length, is_first, runs.follows()))
    moves = _MovesFromOne(runs)
    for run, (length, begins_boot, follows) in enumerate(zip(*columns, strict=True)):
        earlier = [run - back for back in _BACKS[follows]] if follows else []
        if not begins_boot and chains[-1] < run - _LOOK_BACK and moves.possible(chains[-1], run):
            earlier.insert(0, chains[-1])
        best = max(earlier, key=weights.__getitem__) if earlier else -1
        before.append(best)
        weights.append(length + weights[best] if earlier else length)
        if begins_boot:
            chains.append(run)
        elif weights[run] > weights[chains[-1]]:
            chains[-1] = run
    is_kept = np.zeros(len(weights), np.bool_)
    is_kept[list(_linked(chains, before))] = True
    return is_kept


_BACKS = [[back for back in range(_LOOK_BACK, 0, -1) if bits >> (back - 1) & 1] for bits in range(256)]


class _MovesFromOne:
    """Whether later runs may follow one run: asked run by run, found for ever more of them at once."""

    def __init__(self, runs: _Runs) -> None:
        self._runs = runs
        self._start = self._first = self._end = self._ahead = -1
        self._may: list[bool] = []

    def possible(self, start: int, run: int) -> bool:
        """Whether a vehicle can have moved from ``start`` to ``run``, which grows from call to call."""
        if start != self._start:
            self._start, self._end, self._ahead = start, run, _FEWEST_AHEAD
        if run >= self._end:
            self._first, self._end = run, run + self._ahead
            self._ahead = min(2 * self._ahead, _MOST_AHEAD)
            ends, begins = self._runs.end[start : start + 1], self._runs.begin[run : self._end]
            self._may = _can_move(ends, begins).tolist()
        return self._may[run - self._first]


def _linked(chains: list[int], before: list[int]) -> Iterator[int]:
    """All runs of chains, by their last runs and the run before each."""
    for run in chains:
        while run >= 0:
            yield run
            run = before[run]  # noqa: PLW2901

"""Runs of records that follow each other: those of a vehicle, or of a boot."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flight_replay.geometry.arrays import Indices, Integers

Number = TypeVar("Number", bound=np.generic)


class Runs:
    """Runs of ``n`` records: each goes from its ``first`` to before its ``end``, both (m,)."""

    def __init__(self, first: Indices, n: int) -> None:
        self.first = first
        self.end = np.append(first[1:], n)

    def spread(self, values: NDArray[Number]) -> NDArray[Number]:
        """A value of each run (m,) for each of its records (n,)."""
        return np.repeat(values, self.end - self.first)

    def of(self, index: Indices) -> Indices:
        """The run that each record (k,) is in."""
        return np.asarray(np.searchsorted(self.first, index, "right") - 1)

    def cumulated(self, steps: Integers) -> Integers:
        """The sum of the steps (n - 1,) between records up to each record (n,), from 0 in each run."""
        total = np.concatenate([[0], np.cumsum(steps)])
        return np.asarray(total - self.spread(total[self.first]))

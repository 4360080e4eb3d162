"""How much of a correction targets need, learned in flight from how far off the vehicle is.

Leads are those of a firmware, and drag that of an airframe. What a link, a simulator's speed or another
airframe adds shows in flight: a vehicle that is always a little behind on its way is late by the same
time everywhere, and one with more drag is behind wherever its speed has just changed. A slow integral
controller takes that out; what changes from turn to turn it leaves alone.
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats

_LEARNING_S = 15.0
"""Of flight at the usual size until two thirds are learned: much longer than a vehicle takes to react."""
_MEAN_S = 30.0
_LONGEST_STEP_S = 0.5


class LearnedShare:
    """The multiple ``value`` of a correction, a vector that changes with time, that takes the error out."""

    def __init__(self, begin: float, bounds: tuple[float, float], smallest: float) -> None:
        """Begin.

        Args:
            begin: the share until something is learned.
            bounds: the least and the most.
            smallest: square of the correction below which it teaches less.
        """
        self.value = begin
        self._bounds, self._smallest = bounds, smallest
        self._mean_square = smallest
        self._time_s: float | None = None

    def observe(self, time_s: float, behind_m: Floats, along: Floats) -> None:
        """Learn from where the vehicle was.

        What is missing of the share is divided by the mean square of the correction, or by its own square
        where that is larger, so that one place does not teach too much.

        Args:
            time_s: the vehicle's.
            behind_m: from the vehicle to where it was to be (3,).
            along: how far a share of 1 would have moved it (3,).
        """
        step_s = 0.0 if self._time_s is None else time_s - self._time_s
        self._time_s = time_s
        if not 0.0 < step_s <= _LONGEST_STEP_S:
            return
        square = float(along @ along)
        self._mean_square += (square - self._mean_square) * step_s / _MEAN_S
        usual = max(self._mean_square, square, self._smallest)
        missing = float(behind_m @ along) / usual
        self.value = float(np.clip(self.value + missing * step_s / _LEARNING_S, *self._bounds))

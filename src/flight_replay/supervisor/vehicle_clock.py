"""What the vehicle's clock shows now, from the times that its positions carry.

Only a position's arrival is known, not when it was sent. The freshest of the last positions is the
one that was delayed least; how long a target takes to arrive, added to that delay, is the round trip.
"""

from __future__ import annotations

from collections import deque

_RATE_WINDOW_WALL_S, _MIN_RATE_WINDOW_WALL_S = 2.0, 0.25
_FRESH_WINDOW_S = 1.0  # Vehicle time: over longer, the error of the rate counts more than delays differ.
_LONGEST_SILENCE_S = 1.0  # Vehicle time: beyond this, nothing says that the vehicle is still there.


class VehicleClock:
    """Estimates vehicle time between positions; the clock of a simulator may run at any rate."""

    def __init__(self) -> None:
        self._positions: deque[tuple[float, float]] = deque()
        self.rate = 1.0
        """Vehicle seconds a wall-clock second."""

    def received(self, time_s: float, wall_s: float) -> None:
        """A position with the vehicle's time ``time_s`` came at the wall-clock time ``wall_s``."""
        positions = self._positions
        if positions and time_s <= positions[-1][0]:
            return
        if positions and time_s - positions[-1][0] > _LONGEST_SILENCE_S:
            positions.clear()
        positions.append((time_s, wall_s))
        while wall_s - positions[0][1] > _RATE_WINDOW_WALL_S:
            positions.popleft()
        span_wall_s = wall_s - positions[0][1]
        if span_wall_s >= _MIN_RATE_WINDOW_WALL_S:
            self.rate = (time_s - positions[0][0]) / span_wall_s

    def now_s(self, wall_s: float) -> float | None:
        """Vehicle time at ``wall_s``, late by the least delay; None while nothing is received."""
        if not self._positions:
            return None
        newest_s = self._positions[-1][0]
        fresh_s = max(
            time_s + (wall_s - at_wall_s) * self.rate
            for time_s, at_wall_s in self._positions
            if time_s > newest_s - _FRESH_WINDOW_S
        )
        return fresh_s if fresh_s - newest_s <= _LONGEST_SILENCE_S else None

"""What the vehicle's clock shows now, from the times that its positions carry.

Only a position's arrival is known, not when it was sent. The freshest of the last positions is the
one that was delayed least; how long a target takes to arrive, added to that delay, is the round trip.
"""

from __future__ import annotations

from collections import deque

_RATE_WINDOW_WALL_S, _MIN_RATE_WINDOW_WALL_S = 2.0, 0.25
_FRESH_WINDOW_S = 1.0
_LONGEST_SILENCE_S = 1.0  # Vehicle time: beyond this, nothing says that the vehicle is still there.
_HELD_UP_WALL_S = 0.3  # Positions so late were held up, and others with them: all come at once.


class VehicleClock:
    """Estimates vehicle time between positions; the clock of a simulator may run at any rate."""

    def __init__(self, rate: float = 1.0) -> None:
        """Begin; ``rate`` is assumed until it is measured."""
        self._positions: deque[tuple[float, float]] = deque()
        self.rate = rate
        """Vehicle seconds a wall-clock second."""
        self._rate_known = False
        self._held_up_until_wall_s = float("-inf")

    def received(self, time_s: float, wall_s: float) -> None:
        """A position with the vehicle's time ``time_s`` came at the wall-clock time ``wall_s``."""
        positions = self._positions
        if positions and time_s <= positions[-1][0]:
            return
        if positions and self._rate_known and self._late_wall_s(time_s, wall_s) > _HELD_UP_WALL_S:
            self._held_up_until_wall_s = wall_s + _HELD_UP_WALL_S
        silent = bool(positions) and time_s - positions[-1][0] > _LONGEST_SILENCE_S
        if silent or wall_s < self._held_up_until_wall_s:
            positions.clear()  # Only the last that was held up tells the time, and none of them the rate.
        positions.append((time_s, wall_s))
        while wall_s - positions[0][1] > _RATE_WINDOW_WALL_S:
            positions.popleft()
        span_wall_s = wall_s - positions[0][1]
        if span_wall_s >= _MIN_RATE_WINDOW_WALL_S:
            self.rate, self._rate_known = (time_s - positions[0][0]) / span_wall_s, True

    def rate_changed(self, rate: float) -> None:
        """From now on the vehicle's clock runs at another rate: what was received before tells nothing."""
        self._positions.clear()
        self.rate, self._rate_known = rate, True

    def _late_wall_s(self, time_s: float, wall_s: float) -> float:
        """How much longer it is since the last position came than that was sent before this one."""
        last_s, last_wall_s = self._positions[-1]
        return wall_s - last_wall_s - (time_s - last_s) / max(self.rate, 1e-3)

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

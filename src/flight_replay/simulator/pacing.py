"""Simulated time held against the wall clock."""

from __future__ import annotations

# Farther behind than this, the simulation gives up catching up: it is slower, but never in bursts.
_WORTH_CATCHING_UP_S = 0.2


class Pacer:
    """When the next step may be taken; times are a monotonic clock's seconds."""

    def __init__(self, now_s: float) -> None:
        self._next_s = now_s

    def wait_s(self, now_s: float) -> float:
        """How long until the next step; 0 if it is due."""
        return max(0.0, self._next_s - now_s)

    def stepped(self, now_s: float, step_s: float, speedup: float) -> None:
        """A step of ``step_s`` vehicle seconds was taken at ``speedup`` times real time."""
        self._next_s += step_s / speedup
        if now_s - self._next_s > _WORTH_CATCHING_UP_S:
            self._next_s = now_s

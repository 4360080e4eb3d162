"""How long to wait for an answer before asking again, learnt from the answers (as RFC 6298 does)."""

from __future__ import annotations

_FIRST_S = 0.5
_SHORTEST_S = 0.06
_LONGEST_S = 2.5
_BACK_OFF = 1.3


class RoundTrip:
    """The round-trip time of a link, smoothed, and the wait that follows from it."""

    def __init__(self) -> None:
        self._smooth_s: float | None = None
        self._spread_s = 0.0
        self._factor = 1.0

    @property
    def smooth_s(self) -> float:
        """The round-trip time, seconds; 0 before the first answer."""
        return self._smooth_s or 0.0

    @property
    def again_s(self) -> float:
        """Seconds after which an unanswered request is sent again."""
        base_s = _FIRST_S if self._smooth_s is None else self._smooth_s + 4 * self._spread_s
        return min(max(base_s, _SHORTEST_S) * self._factor, _LONGEST_S)

    def took(self, seconds: float) -> None:
        """A request that was sent once was answered after ``seconds``."""
        self._factor = 1.0
        if self._smooth_s is None:
            self._smooth_s, self._spread_s = seconds, seconds / 2
            return
        self._spread_s += (abs(seconds - self._smooth_s) - self._spread_s) / 4
        self._smooth_s += (seconds - self._smooth_s) / 8

    def lost(self) -> None:
        """A request was not answered in time: wait a little longer, in case the link is slow, not lossy."""
        self._factor = min(self._factor * _BACK_OFF, 4.0)

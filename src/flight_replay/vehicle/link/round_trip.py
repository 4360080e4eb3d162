"""How long to wait for an answer before asking again, and how much to have under way meanwhile.

Both follow from the round-trip times of late. Their median counts: an answer that was lost and
given again by the vehicle's own clock, a second later, would spoil a mean.
"""

from __future__ import annotations

from collections import deque
from statistics import median

_FIRST_S = 0.7  # Before the first answer: about the round trip of a slow radio.
_SHORTEST_S = 0.04
_LONGEST_S = 3.0
_MARGIN = 1.5
_KEPT = 9
_PATIENT_LOSSES = 4  # After each so many in a row, wait twice as long: the link may have become slower.
_LEAST_WINDOW = 2  # One message ahead shows whether a message or its answer was lost.
_MOST_WINDOW = 24
_PER_MESSAGE_S = 0.04  # One more message under way for each such part of the round trip.


class RoundTrip:
    """The round-trip time of a link, and what follows from it."""

    def __init__(self) -> None:
        self._times_s: deque[float] = deque(maxlen=_KEPT)
        self._losses = 0

    @property
    def typical_s(self) -> float:
        """The round-trip time, seconds; a careful guess before the first answer."""
        return median(self._times_s) if self._times_s else _FIRST_S

    @property
    def again_s(self) -> float:
        """Seconds after which an unanswered request is sent again."""
        wait_s = max(self.typical_s * _MARGIN, _SHORTEST_S)
        return min(wait_s * 2.0 ** (self._losses // _PATIENT_LOSSES), _LONGEST_S)

    @property
    def window(self) -> int:
        """How many messages may be under way."""
        fitting = int(self.typical_s / _PER_MESSAGE_S) if self._times_s else _LEAST_WINDOW
        return max(_LEAST_WINDOW, min(fitting, _MOST_WINDOW))

    def guess(self, seconds: float) -> None:
        """Something took ``seconds`` that may not be the link's alone: better than nothing."""
        if not self._times_s:
            self.took(seconds)

    def took(self, seconds: float) -> None:
        """A request that was sent once was answered after ``seconds``."""
        self._losses = 0
        self._times_s.append(seconds)

    def lost(self) -> None:
        """A request was not answered in time."""
        self._losses += 1

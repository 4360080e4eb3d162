"""The round-trip time of a link, and from it: when to send a request again, how many to have in flight.

Both follow from the median of the latest round trips: an answer that was lost and repeated by the
vehicle a second later would spoil a mean. Who measures applies Karn's rule (RFC 6298, section 3): a
request that was sent more than once is not measured, because its answer may be to any of them.
"""

from __future__ import annotations

from collections import deque
from contextlib import suppress
from statistics import median

from flight_replay.mavlink import Message

NS_PER_S = 1e9
_INITIAL_S = 0.7  # Before the first measurement: about the round trip of a slow radio.
_MIN_RETRY_S = 0.04
_MAX_RETRY_S = 3.0
_RETRY_FACTOR = 1.5
_KEPT = 9
_KEPT_PINGS = 256  # More than are ever on their way.
_LOSSES_PER_BACKOFF = 4  # After so many losses in a row the wait doubles: the link may have become slower.
_MIN_WINDOW = 2  # One message ahead shows whether a message or its answer was lost.
_MAX_WINDOW = 24
_SECONDS_PER_MESSAGE = 0.04  # One more message in flight for each such part of the round trip.


class RoundTrip:
    """The round-trip time of a link, and the timing of requests that follows from it."""

    def __init__(self) -> None:
        self._times_s: deque[float] = deque(maxlen=_KEPT)
        self._losses = 0
        self._pings_ns: deque[int] = deque(maxlen=_KEPT_PINGS)

    @property
    def median_s(self) -> float:
        """The round-trip time, seconds; a long one is assumed before the first measurement."""
        return median(self._times_s) if self._times_s else _INITIAL_S

    @property
    def from_freshest_s(self) -> float:
        """From the freshest answer, which was delayed least, until a message sent now is there, seconds."""
        return (min(self._times_s) + self.median_s) / 2 if self._times_s else _INITIAL_S

    @property
    def retry_s(self) -> float:
        """Seconds after which an unanswered request is sent again; backs off while requests are lost."""
        wait_s = max(self.median_s * _RETRY_FACTOR, _MIN_RETRY_S)
        return min(wait_s * 2.0 ** (self._losses // _LOSSES_PER_BACKOFF), _MAX_RETRY_S)

    @property
    def window(self) -> int:
        """How many messages may be in flight."""
        fitting = int(self.median_s / _SECONDS_PER_MESSAGE) if self._times_s else _MIN_WINDOW
        return max(_MIN_WINDOW, min(fitting, _MAX_WINDOW))

    def estimated(self, seconds: float) -> None:
        """An upper bound of the round trip: counts only if nothing was measured yet."""
        if not self._times_s:
            self.measured(seconds)

    def measured(self, seconds: float) -> None:
        """A request that was sent once was answered after ``seconds``."""
        self._losses = 0
        self._times_s.append(seconds)

    def pinged(self, stamp_ns: int) -> None:
        """A ping with this stamp was sent, which the answer repeats."""
        self._pings_ns.append(stamp_ns)

    def answered(self, timesync: Message, now_s: float) -> None:
        """A TIMESYNC came; counts once, and only if it answers a ping of ours.

        Other stations keep time by it, too, and ArduPilot 4.6 sends its replies to everybody.
        """
        with suppress(ValueError):
            if timesync.tc1 != 0:
                self._pings_ns.remove(timesync.ts1)
                self.measured(now_s - timesync.ts1 / NS_PER_S)

    def lost(self) -> None:
        """A request was not answered in time."""
        self._losses += 1

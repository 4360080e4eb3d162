"""When waits end, when requests are sent again and when progress is told: by two clocks.

The vehicle's clock is what a flight's times mean; the clock here bounds them, because a
simulator's may run 20 times faster, a frozen vehicle's not at all.
"""

from __future__ import annotations

from flight_replay.supervisor.vehicle_monitor import Watch

_AGAIN_WALL_S = 0.15  # No request is sent again sooner by the clock here: the answer may be under way.
_STOPPED_WALL_S = 2.0  # Where the vehicle's clock stands still, this time here will do.
_NEVER_S = float("-inf")


class Deadline:
    """The end of a wait: ``limit_s`` of the vehicle's clock, within bounds by the clock here.

    Time in which the vehicle was not heard does not count. A clock that runs fast leaves at least
    ``least_wall_s`` here, so that lost packets can be sent again; one that stands still, at most
    three times the limit.
    """

    def __init__(self, watch: Watch, limit_s: float) -> None:
        self._watch = watch
        self._limit_s = limit_s
        self.restart()

    def restart(self) -> None:
        """Wait as long again from now."""
        self._attended_s, self._wall_s = self._watch.attended_s, self._watch.wall_s

    @property
    def passed(self) -> bool:
        """Whether the wait is over."""
        wall_s = self._watch.wall_s - self._wall_s
        vehicle_s = self._watch.attended_s - self._attended_s
        least_s = min(self._watch.deadlines.least_wall_s, self._limit_s)
        return wall_s > 3 * self._limit_s or (vehicle_s > self._limit_s and wall_s > least_s)


class Repeat:
    """Says when a request is to be sent (at once, then again while nothing comes of it).

    Never while something that the vehicle reported is not yet taken in: it may be the answer, or
    what makes the request wrong.
    """

    def __init__(self, watch: Watch) -> None:
        self._watch = watch
        self._time_s = self._wall_s = _NEVER_S

    def due(self, again_s: float, least_wall_s: float = _AGAIN_WALL_S) -> bool:
        """Whether ``again_s`` of the vehicle's clock, and enough here, passed since this last said yes."""
        wall_s = self._watch.wall_s - self._wall_s
        vehicle_s = self._watch.time_s - self._time_s
        early = wall_s < least_wall_s or (vehicle_s < again_s and wall_s < max(again_s, _STOPPED_WALL_S))
        if early or not self._watch.caught_up:
            return False
        self.restart()
        return True

    def restart(self) -> None:
        """Count from now."""
        self._time_s, self._wall_s = self._watch.time_s, self._watch.wall_s


class Pace:
    """Says when progress is to be told: every second by the vehicle's clock, or by the one here."""

    def __init__(self, watch: Watch) -> None:
        self._watch = watch
        self._time_s = self._wall_s = _NEVER_S

    def due(self) -> bool:
        """Whether a second has passed by either clock since this last said yes."""
        if self._watch.time_s - self._time_s < 1.0 and self._watch.wall_s - self._wall_s < 1.0:
            return False
        self._time_s, self._wall_s = self._watch.time_s, self._watch.wall_s
        return True

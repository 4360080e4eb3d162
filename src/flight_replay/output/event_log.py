"""The events of a replay as timed lines of text, for the report."""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.events import Climbing, DistanceToWaypoint, Event, Progress, VehicleState, Waiting
from flight_replay.output.event_text import event_line, is_problem

_REPEATED_READINGS = Climbing | DistanceToWaypoint | Progress


@dataclass(frozen=True, slots=True)
class LoggedEvent:
    """A line of text; ``time_s`` is the vehicle's clock, None before its first position."""

    time_s: float | None
    text: str
    warning: bool


class EventLog:
    """A listener that keeps a line for every event, except readings that are repeated many times a second."""

    def __init__(self) -> None:
        self.entries: list[LoggedEvent] = []
        self._time_s: float | None = None
        self._last_wait: Waiting | None = None

    def listener(self, event: Event) -> None:
        """Append the event's line, if it has one; a wait is logged again only when its reason changes."""
        if isinstance(event, VehicleState):
            self._time_s = event.time_s
            return
        if isinstance(event, _REPEATED_READINGS) or event == self._last_wait:
            return
        if isinstance(event, Waiting):
            self._last_wait = event
        line = event_line(event)
        if line is not None:
            self.entries.append(LoggedEvent(self._time_s, line.strip(), is_problem(event)))

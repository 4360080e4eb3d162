"""The events of a replay as timed lines of text, for the report."""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.events import (
    Climbing,
    DistanceToStart,
    DistanceToWaypoint,
    Event,
    Following,
    Progress,
    VehicleState,
    Waiting,
)
from flight_replay.output.event_text import event_line, is_problem

_REPEATED_READINGS = Climbing | DistanceToStart | DistanceToWaypoint | Progress


@dataclass(frozen=True, slots=True)
class LoggedEvent:
    """A line of text; ``time_s`` is the vehicle's clock, None before its first position."""

    time_s: float | None
    text: str
    warning: bool


class EventLog:
    """A listener that keeps a line for every event, except readings that are repeated all along."""

    def __init__(self) -> None:
        self.entries: list[LoggedEvent] = []
        self._time_s: float | None = None
        self._waits: Waiting | bool | None = None

    def listener(self, event: Event) -> None:
        """Append the event's line, if it has one.

        What is waited for is logged again when its reason changes, following when the recording begins to
        wait for the vehicle, or goes on.
        """
        if isinstance(event, VehicleState):
            self._time_s = event.time_s
            return
        if isinstance(event, _REPEATED_READINGS):
            return
        if isinstance(event, Waiting | Following):
            waits = event.waiting if isinstance(event, Following) else event
            if waits == self._waits:
                return
            self._waits = waits
        line = event_line(event)
        if line is not None:
            self.entries.append(LoggedEvent(self._time_s, line.strip(), is_problem(event)))

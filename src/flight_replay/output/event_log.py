"""The events of a replay as lines with the vehicle's time: what a report tells of the flight."""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.events import Climbing, DistanceToWaypoint, Event, Progress, VehicleState, Waiting
from flight_replay.output.event_text import sentence, went_wrong

_PASSING = Climbing | DistanceToWaypoint | Progress


@dataclass(frozen=True, slots=True)
class Entry:
    """One line: ``time_s`` by the vehicle's clock, None before it was heard."""

    time_s: float | None
    text: str
    warning: bool


class Journal:
    """A listener that keeps what happened, without the readings that repeat themselves."""

    def __init__(self) -> None:
        self.entries: list[Entry] = []
        self._time_s: float | None = None
        self._waiting: Waiting | None = None

    def listener(self, event: Event) -> None:
        """Keep the event if it is one that a person would want to read later."""
        if isinstance(event, VehicleState):
            self._time_s = event.time_s
            return
        if isinstance(event, _PASSING) or event == self._waiting:
            return
        if isinstance(event, Waiting):
            self._waiting = event
        line = sentence(event)
        if line is not None:
            self.entries.append(Entry(self._time_s, line.strip(), went_wrong(event)))

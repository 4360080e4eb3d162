"""Where a replay stands: what its events add up to, for displays that show it at a glance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import singledispatchmethod

from flight_replay.events import (
    Climbing,
    DistanceToWaypoint,
    Event,
    Finished,
    LinkLost,
    LinkRestored,
    Notice,
    Phase,
    PhaseStarted,
    Progress,
    ReturnCommanded,
    StatusText,
    VehicleState,
    Waiting,
    WaypointReached,
)

WORDS_KEPT = 3
"""The autopilot's last words on show."""


@dataclass(slots=True)
class Status:
    """The state of a replay, made of the events so far."""

    phase: Phase | None = None
    begun: list[Phase] = field(default_factory=list)
    progress: Progress | None = None
    waiting: str = ""
    target_m: float | None = None
    heading: DistanceToWaypoint | None = None
    reached: list[int] = field(default_factory=list)
    vehicle: VehicleState | None = None
    words: tuple[StatusText, ...] = ()
    trouble: str = ""
    rtl_confirmed: bool | None = None
    ended: str | None = None

    @property
    def speed_m_s(self) -> float:
        """Ground speed; not a number before the vehicle was heard."""
        if self.vehicle is None:
            return math.nan
        north_m_s, east_m_s, _ = self.vehicle.velocity_m_s
        return math.hypot(north_m_s, east_m_s)

    @singledispatchmethod
    def update(self, event: Event) -> None:
        """Take an event in; those that change nothing here are ignored."""

    @update.register
    def _phase(self, event: PhaseStarted) -> None:
        self.phase, self.progress, self.waiting = event.phase, None, ""
        if event.phase not in self.begun:
            self.begun.append(event.phase)

    @update.register
    def _progress(self, event: Progress) -> None:
        self.progress = event if event.done < event.total else None

    @update.register
    def _waiting(self, event: Waiting) -> None:
        self.waiting = event.reason

    @update.register
    def _climbing(self, event: Climbing) -> None:
        self.target_m = event.target_m

    @update.register
    def _heading(self, event: DistanceToWaypoint) -> None:
        self.heading = event

    @update.register
    def _reached(self, event: WaypointReached) -> None:
        self.reached.append(event.seq)

    @update.register
    def _vehicle(self, event: VehicleState) -> None:
        self.vehicle = event

    @update.register
    def _words(self, event: StatusText) -> None:
        self.words = (*self.words, event)[-WORDS_KEPT:]

    @update.register
    def _notice(self, event: Notice) -> None:
        if event.warning:
            self.trouble = event.text

    @update.register
    def _lost(self, event: LinkLost) -> None:
        self.trouble = f"nothing heard for {event.silent_s:.0f} s"

    @update.register
    def _back(self, event: LinkRestored) -> None:
        self.trouble = ""

    @update.register
    def _returning(self, event: ReturnCommanded) -> None:
        self.rtl_confirmed = event.confirmed

    @update.register
    def _finished(self, event: Finished) -> None:
        self.ended = event.ended

"""The current status of a replay, made of its events, for the live display and the live map."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import singledispatchmethod

from flight_replay.events import (
    Climbing,
    DistanceToStart,
    DistanceToWaypoint,
    Event,
    Finished,
    Following,
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
)

STATUS_TEXTS_SHOWN = 3
"""How many of the autopilot's last texts are shown."""


@dataclass(slots=True)
class ReplayStatus:
    """The latest of each kind of event; None or empty before the first."""

    phase: Phase | None = None
    started: list[Phase] = field(default_factory=list)
    progress: Progress | None = None
    waiting: str = ""
    target_altitude_m: float | None = None
    current_waypoint: DistanceToWaypoint | None = None
    following: Following | None = None
    to_start_m: float | None = None
    vehicle: VehicleState | None = None
    status_texts: tuple[StatusText, ...] = ()
    warning: str = ""
    rtl_confirmed: bool | None = None
    ended: str | None = None
    problem: str | None = None
    landed: bool = False

    @property
    def mode(self) -> str:
        """The flight mode: once the vehicle confirmed RTL, that, though no further state may come."""
        if self.rtl_confirmed:
            return "RTL"
        return "" if self.vehicle is None else self.vehicle.mode

    @property
    def speed_m_s(self) -> float:
        """Ground speed; NaN before the first position."""
        if self.vehicle is None:
            return math.nan
        north_m_s, east_m_s, _ = self.vehicle.velocity_m_s
        return math.hypot(north_m_s, east_m_s)

    @singledispatchmethod
    def update(self, event: Event) -> None:
        """Apply an event; events that change nothing here are ignored."""

    @update.register
    def _phase_started(self, event: PhaseStarted) -> None:
        self.phase, self.progress, self.waiting = event.phase, None, ""
        if event.phase not in self.started:
            self.started.append(event.phase)

    @update.register
    def _progress(self, event: Progress) -> None:
        self.progress = event if event.done < event.total else None

    @update.register
    def _waiting(self, event: Waiting) -> None:
        self.waiting = event.reason

    @update.register
    def _climbing(self, event: Climbing) -> None:
        self.target_altitude_m = event.target_m

    @update.register
    def _distance_to_waypoint(self, event: DistanceToWaypoint) -> None:
        self.current_waypoint = event

    @update.register
    def _distance_to_start(self, event: DistanceToStart) -> None:
        self.to_start_m = event.distance_m

    @update.register
    def _following(self, event: Following) -> None:
        self.following = event

    @update.register
    def _vehicle_state(self, event: VehicleState) -> None:
        self.vehicle = event

    @update.register
    def _status_text(self, event: StatusText) -> None:
        self.status_texts = (*self.status_texts, event)[-STATUS_TEXTS_SHOWN:]

    @update.register
    def _notice(self, event: Notice) -> None:
        if event.warning:
            self.warning = event.text

    @update.register
    def _link_lost(self, event: LinkLost) -> None:
        self.warning = "link lost"

    @update.register
    def _link_restored(self, event: LinkRestored) -> None:
        self.warning = ""

    @update.register
    def _return_commanded(self, event: ReturnCommanded) -> None:
        self.rtl_confirmed = event.confirmed

    @update.register
    def _finished(self, event: Finished) -> None:
        self.ended, self.problem, self.landed = event.ended, event.problem, event.landed


def end_text(status: ReplayStatus) -> str:
    """How a flight that is over ended, and what became of the vehicle, such as "duration, RTL confirmed"."""
    if status.landed:
        return f"{status.ended}, landed"
    if status.rtl_confirmed is None:
        return status.ended or ""
    return f"{status.ended}, RTL {'confirmed' if status.rtl_confirmed else 'not confirmed'}"


def following_text(following: Following) -> str:
    """How far a recording is followed, such as "24 of 60 s" or "begins in 4 s"."""
    if following.recording_s < 0:
        return f"begins in {math.ceil(-following.recording_s)} s"
    return f"{following.recording_s:.0f} of {following.of_s:.0f} s"


def battery_text(vehicle: VehicleState) -> str:
    """Voltage and remaining percentage, as far as they are known, such as "12.6 V 84 %"."""
    values = ((vehicle.battery_v, ".1f", "V"), (vehicle.battery_percent, ".0f", "%"))
    return " ".join(
        f"{value:{precision}} {unit}"
        for value, precision, unit in values
        if value is not None and math.isfinite(value)
    )

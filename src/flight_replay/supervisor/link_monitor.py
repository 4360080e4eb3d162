"""Detects a lost link: emits its loss and its return, and tells when the flight has to end."""

from __future__ import annotations

from flight_replay.events import LinkLost, LinkRestored, Listener
from flight_replay.supervisor.flight_plan import Deadlines
from flight_replay.supervisor.vehicle_interface import Clock

_STALL_S = 1.0
"""Who has not looked for so long was stopped, or starved: what came meanwhile is not processed yet."""


class LinkMonitor:
    """Measures, in wall-clock time, how long no data has come from the vehicle while this program ran."""

    def __init__(self, clock: Clock, deadlines: Deadlines) -> None:
        self._clock, self._deadlines = clock, deadlines
        self._received_s = self._checked_s = clock.monotonic_s()
        self._lost = False

    @property
    def _silent_s(self) -> float:
        return self._clock.monotonic_s() - self._received_s

    def received(self, emit: Listener) -> None:
        """Data came from the vehicle; emit ``LinkRestored`` if the link had been lost."""
        if self._lost:
            self._lost = False
            emit(LinkRestored(self._silent_s))
        self._received_s = self._checked_s = self._clock.monotonic_s()

    def check(self, emit: Listener) -> bool:
        """Whether the link has been silent for so long that the flight ends; emits ``LinkLost`` once."""
        now_s = self._clock.monotonic_s()
        self._received_s += max(now_s - self._checked_s - _STALL_S, 0.0)
        self._checked_s = now_s
        if self._silent_s >= self._deadlines.link_lost_wall_s and not self._lost:
            self._lost = True
            emit(LinkLost(self._silent_s))
        return self._silent_s >= self._deadlines.give_up_wall_s

    @property
    def silence(self) -> str:
        """How long no data has come, as a phrase; empty while the link is up."""
        return f"no data for {self._silent_s:.0f} s" if self._lost else ""

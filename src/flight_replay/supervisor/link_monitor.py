"""Whether the vehicle is heard: silence is told when it matters, and ends the flight when it lasts."""

from __future__ import annotations

from flight_replay.events import LinkLost, LinkRestored, Listener
from flight_replay.supervisor.flight_plan import Deadlines
from flight_replay.supervisor.vehicle_interface import Clock


class Silence:
    """Times how long nothing was heard, by the clock here."""

    def __init__(self, clock: Clock, deadlines: Deadlines) -> None:
        self._clock, self._deadlines = clock, deadlines
        self._heard_s = clock.monotonic_s()
        self._lost = False

    @property
    def _silent_s(self) -> float:
        return self._clock.monotonic_s() - self._heard_s

    def heard(self, emit: Listener) -> None:
        """Something came; tell it if the link had been lost."""
        if self._lost:
            self._lost = False
            emit(LinkRestored(self._silent_s))
        self._heard_s = self._clock.monotonic_s()

    def check(self, emit: Listener) -> bool:
        """Tell a loss once; whether the silence has lasted so long that the flight must be given up."""
        if self._silent_s >= self._deadlines.silence_s and not self._lost:
            self._lost = True
            emit(LinkLost(self._silent_s))
        return self._silent_s >= self._deadlines.link_back_s

    @property
    def words(self) -> str:
        """The silence in words, if the link is lost."""
        return f"nothing was heard from it for {self._silent_s:.0f} s" if self._lost else ""

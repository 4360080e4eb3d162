"""What a flight came to, also one that was interrupted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flight_replay.output.outcome import Outcome
    from flight_replay.planning.route import Route
    from flight_replay.supervisor import FlightRecord


@dataclass(frozen=True, slots=True, eq=False)
class FlightResult:
    """A flight, the vehicle that flew it, and its errors."""

    vehicle: str
    simulated: bool
    outcome: Outcome

    @property
    def record(self) -> FlightRecord:
        """How the flight went."""
        return self.outcome.record


class ReplayInterrupted(KeyboardInterrupt):
    """Ctrl-C or its like ended a flight, for which RTL was commanded, or came after it.

    ``flight`` is what was flown of ``route``; the vehicle is closed.
    """

    def __init__(self, route: Route, flight: FlightResult) -> None:
        super().__init__()
        self.route, self.flight = route, flight

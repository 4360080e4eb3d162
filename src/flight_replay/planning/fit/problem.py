"""What to fit, and how many flights in the model that may take."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.objective import Evaluation, evaluate
from flight_replay.planning.fit.reference import Hover, LocalTrack
from flight_replay.planning.fit.simulated_draft import SimulatedDraft, simulate_draft
from flight_replay.simulator.dynamics.limits import Limits


@dataclass(frozen=True, slots=True, eq=False)
class FitProblem:
    """What to fit: the recording, its hovers, and what the vehicle may do.

    ``timed`` says whether the recorded speed is to be kept; ``step_s`` is the step of the model.
    """

    recording: LocalTrack
    hovers: list[Hover]
    limits: Limits
    timed: bool
    step_s: float

    def simulate(self, draft: Draft) -> SimulatedDraft:
        """A draft as the model flies it, at its own speeds."""
        return simulate_draft(draft, self.limits, self.step_s, self.recording.home_amsl_m)

    def evaluate(self, draft: Draft) -> Evaluation:
        """How a draft is flown, against the recording."""
        return evaluate(self.simulate(draft), self.recording, timed=self.timed)


@dataclass(frozen=True, slots=True, eq=False)
class FirstDraft:
    """A draft to begin with, and the hovers by the place (from 1) at which they are waited for."""

    draft: Draft
    hovers: dict[int, Hover]


class Budget:
    """Flights in the model that the search may take; ``spend`` tells of them as they are flown."""

    def __init__(self, flights: int, progress: Callable[[int, int], None]) -> None:
        self.flights = flights
        self.spent = 0.0
        self._progress = progress

    def spend(self, flights: float) -> None:
        """Count flights, or parts of one."""
        self.spent += flights
        self._progress(min(round(self.spent), self.flights), self.flights)

    def affords(self, flights: float) -> bool:
        """Whether so many flights are left."""
        return self.spent + flights <= self.flights

    def finish(self) -> None:
        """Tell that the work is done."""
        self._progress(self.flights, self.flights)

"""What to fit, and how many flights in the model that may take."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.objective import Evaluation, evaluate
from flight_replay.planning.fit.reference import LEAST_HOLD_S, Hover, LocalTrack
from flight_replay.planning.fit.simulated_draft import SimulatedDraft, simulate_draft
from flight_replay.planning.fit.speed_schedule import with_speeds
from flight_replay.simulator.dynamics.limits import Limits

_simulated = lru_cache(maxsize=4)(simulate_draft)
"""The best draft is looked at several times, with another clock or in exact steps."""
# Durations of flights, and the steps of the model that are exact enough and can be afforded.
_EXACT_STEPS_S = ((1000.0, 3000.0), (0.02, 0.1))
_ON_BOARD_STEPS_S = ((1000.0, 3000.0), (0.0025, 0.1))
"""Steps of the autopilot's loop, as far as they can be afforded."""


_LEAPING_M_S2 = 5.0
"""With more acceleration than twice ArduCopter's default a spline from a stop may leap ahead."""


@dataclass(frozen=True, slots=True, eq=False)
class FitProblem:
    """What to fit: the recording, its hovers, and what the vehicle may do.

    ``timed`` says whether the recorded speed is to be kept; ``step_s`` is the step of the model. With
    ``frame``, drafts are flown as mission items hold them, the fit's metres around its origin.
    """

    recording: LocalTrack
    hovers: list[Hover]
    limits: Limits
    timed: bool
    step_s: float
    frame: FlatFrame | None = None

    def held(self, draft: Draft) -> Draft:
        """A draft as mission items hold it."""
        return draft if self.frame is None else draft.as_items_hold_it(self.frame)

    def simulate(self, draft: Draft) -> SimulatedDraft:
        """A draft as items hold it and the model flies it, at its own speeds."""
        return _simulated(self.held(draft), self.limits, self.step_s, self.recording.takeoff)

    def flights_of(self, steps: int, flight: SimulatedDraft) -> float:
        """How many flights such as one in steps of ``step_s`` so many steps of the model are."""
        return steps * self.step_s / max(float(flight.time_s[-1]), self.step_s)

    def least_leg_s(self, draft: Draft, caps_m_s: Floats) -> Floats:
        """What each leg of a draft (n,) takes at the highest speeds (n,), waiting not counted."""
        hurried = replace(draft, hold_s=np.minimum(draft.hold_s, LEAST_HOLD_S))
        passed_s = self.simulate(with_speeds(hurried, caps_m_s)).passed_s
        return np.diff(passed_s, prepend=0.0) - hurried.hold_s

    @property
    def exact(self) -> FitProblem:
        """The same in steps that are short enough to tell how late the vehicle will be, where that counts."""
        return self._in_steps(_EXACT_STEPS_S)

    @property
    def on_board(self) -> FitProblem:
        """The same in steps of the autopilot, in which a draft is timed in the end, where that counts."""
        return self._in_steps(_ON_BOARD_STEPS_S)

    def _in_steps(self, steps_s: tuple[tuple[float, float], tuple[float, float]]) -> FitProblem:
        """The same, where the recorded speed is to be kept in steps that a recording so long can afford."""
        if not self.timed:
            return self
        step_s = float(np.interp(self.recording.time_s[-1], *steps_s))
        return replace(self, step_s=min(self.step_s, step_s))

    @property
    def straight_starts(self) -> bool:
        """Whether stops are left straight.

        What rounding leaves of a straight leg's speed, 0.1 micrometre a second or so, decides how far the
        first steps of a spline go (SplineCurve::advance_target_along_track): at default limits that is worth
        hundredths of a second, at four times their acceleration a second.
        """
        return self.timed and self.limits.wp_accel_m_s2 > _LEAPING_M_S2

    def evaluate(self, draft: Draft) -> Evaluation:
        """How a draft is flown, against the recording."""
        return self.compared(self.simulate(draft))

    def compared(self, flight: SimulatedDraft) -> Evaluation:
        """A flight in steps of ``step_s`` against the recording."""
        return evaluate(flight, self.recording, timed=self.timed)


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

    def spend_besides(self, flights: float) -> None:
        """Count flights that leave as many as there were."""
        self.flights += round(flights)
        self.spend(round(flights))

    def affords(self, flights: float, overdrawn: float = 0.0) -> bool:
        """Whether so many flights are left, with a share more than there may be to overdraw."""
        return self.spent + flights <= (1.0 + overdrawn) * self.flights

    def finish(self) -> None:
        """Tell that the work is done."""
        self._progress(self.flights, self.flights)

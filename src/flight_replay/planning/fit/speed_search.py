"""The speed of every leg, found in the model leg after leg, so that each place is left when it ought to be.

As a leg begins, copies of the copter fly it at one speed after another: the speed before, and then
what the last two trials say of the answer, as in a secant search. What is kept is exact: it is the same
model, with all that came before, that flies the finished mission.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite, log

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.legs.copter_snapshot import CopterSnapshot
from flight_replay.planning.fit.simulated_draft import climbing_copter, items_of
from flight_replay.planning.fit.speed_schedule import SLOWEST_M_S, Schedule
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.copter import Copter

_MOST_TRIALS = 5
_PUNCTUAL_S = 0.06
_NEARER_S = 0.02
"""A speed that is not punctual is taken for another only if it is nearer by so much."""
_SAME_RATIO = 1.01
_SHORTEST_S = 0.05
_SLOPES = (-4.0, -0.25)
_PATIENCE_S = 30.0


@dataclass(frozen=True, slots=True)
class _Trial:
    """A leg flown at a speed: after how many steps the next began, and by how much that was late."""

    speed_m_s: float
    steps: int
    late_s: float


class SpeedSearch:
    """One pass over the legs of a draft; ``steps`` counts the model's steps that it took."""

    def __init__(
        self, plan: Schedule, caps_m_s: Floats, limits: Limits, step_s: float, home_amsl_m: float
    ) -> None:
        """Begin.

        Args:
            plan: the draft, at least two places, and when each place ought to be left.
            caps_m_s: highest speed of each leg (n,).
            limits: what the vehicle may do.
            step_s: duration of the model's steps.
            home_amsl_m: the place of take-off above sea level.
        """
        self._plan, self._caps_m_s, self._limits, self._step_s = plan, caps_m_s, limits, step_s
        self._items, self._seqs = items_of(replace(plan.draft, speed_m_s=caps_m_s), every_speed=True)
        self._copter = climbing_copter(plan.draft, limits, step_s, home_amsl_m)
        self._copter.start_auto(self._items)
        self._begin_s = 0.0
        self._snapshot = self._taken()
        self.steps = 0

    def run(self) -> Floats:
        """The speeds (n,) with which the places are left as nearly as can be on time."""
        self._advance(self._steps_past(self._snapshot.copy(), 0, _PATIENCE_S))
        self._begin_s = self._copter.time_s
        speeds = np.full(len(self._plan.draft), np.nan)
        for place in range(1, len(speeds)):
            best = self._best(place, float(speeds[place - 1]))
            speeds[place] = best.speed_m_s
            self._ask_for(place, best.speed_m_s)
            self._advance(best.steps)
        return speeds

    @property
    def _now_s(self) -> float:
        return self._copter.time_s - self._begin_s

    def _best(self, place: int, before_m_s: float) -> _Trial:
        """The speed that ends a leg nearest to when it ought to end; rather the one before than another."""
        low, high = SLOWEST_M_S, float(self._caps_m_s[place])
        speed = min(before_m_s, high) if isfinite(before_m_s) else high
        best: _Trial | None = None
        trials: list[_Trial] = []
        for _ in range(_MOST_TRIALS):
            trial = self._tried(place, speed)
            trials.append(trial)
            if best is None or abs(trial.late_s) < abs(best.late_s) - _NEARER_S:
                best = trial
            if trial.late_s > 0:
                low = max(low, speed)
            else:
                high = min(high, speed)
            if abs(trial.late_s) <= _PUNCTUAL_S or high <= low * _SAME_RATIO:
                break
            speed = self._next_speed(place, trials[-2:], low, high)
        assert best is not None, "there are trials"
        return best

    def _tried(self, place: int, speed_m_s: float) -> _Trial:
        self._ask_for(place, speed_m_s)
        allowed_s = max(float(self._plan.leave_s[place]) - self._now_s, 0.0)
        steps = self._steps_past(self._snapshot.copy(), place, 3 * allowed_s + _PATIENCE_S)
        left_s = self._now_s + (steps - 1) * self._step_s
        return _Trial(speed_m_s, steps, left_s - float(self._plan.leave_s[place]))

    def _next_speed(self, place: int, trials: list[_Trial], low: float, high: float) -> float:
        """The speed at which a leg would end on time if its duration went with a power of it."""
        wanted_s = self._moving_s(place, 0.0)
        durations = [self._moving_s(place, trial.late_s) for trial in trials]
        slope = -1.0
        if len(trials) > 1 and abs(log(durations[1] / durations[0])) > 1e-3:
            slope = log(trials[1].speed_m_s / trials[0].speed_m_s) / log(durations[1] / durations[0])
        slope = min(max(slope, _SLOPES[0]), _SLOPES[1])
        speed = float(trials[-1].speed_m_s * (wanted_s / durations[-1]) ** slope)
        if low < speed < high:
            return speed
        if len(trials) > 1:
            return float((low * high) ** 0.5)
        return high if speed >= high else low

    def _moving_s(self, place: int, late_s: float) -> float:
        """How long a leg takes that ends so late, waiting not counted."""
        hold_s = float(self._plan.draft.hold_s[place])
        return max(float(self._plan.leave_s[place]) + late_s - hold_s - self._now_s, _SHORTEST_S)

    def _ask_for(self, place: int, speed_m_s: float) -> None:
        at = self._seqs[place] - 2  # The speed's item, just before the place's.
        self._items[at] = replace(self._items[at], params=(1.0, round(speed_m_s, 2), 0.0, 0.0))

    def _taken(self) -> CopterSnapshot:
        return CopterSnapshot(self._copter, (self._items, self._limits))

    def _advance(self, steps: int) -> None:
        """Fly on to one step before the next leg begins: its speed is asked for as it does."""
        for _ in range(steps - 1):
            self._copter.step()
        self._snapshot = self._taken()

    def _steps_past(self, copter: Copter, place: int, most_s: float) -> int:
        """How many steps it takes until a copter is on the way to the place after."""
        began, seq, most_steps = copter.steps, self._seqs[place], int(most_s / self._step_s)
        while (
            copter.mission is not None and not copter.mission.completed and copter.steps - began < most_steps
        ):
            if copter.mission.seq is not None and copter.mission.seq > seq:
                break
            copter.step()
        self.steps += copter.steps - began
        return copter.steps - began

"""The speed of every leg, found in the model leg after leg, so that each place is left when it ought to be.

As a leg begins, copies of the copter fly it at one speed after another: the speed that the draft has
already, or the speed before, and then what the last two trials say of the answer, as in a secant search.
What is kept is exact: it is the same model, with all that came before, that flies the finished mission.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite, log

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.climb_speeds import leg_climbs_m_s, steep_legs
from flight_replay.planning.fit.draft import with_every_speed
from flight_replay.planning.fit.reference import DECIMALS, Takeoff
from flight_replay.planning.fit.simulated_draft import (
    SimulatedDraft,
    climb_item,
    copter_after_takeoff,
    flight_of,
    items_of,
)
from flight_replay.planning.fit.speed_schedule import SLOWEST_M_S, Schedule, slowest_m_s, with_speeds
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.flight.copter_copy import copter_copy
from flight_replay.simulator.flight.flown_positions import (
    AXES,
    longest_step_m,
    passed_s,
    positions_on_leg,
    positions_to_end,
)

_MOST_TRIALS = 5
_PUNCTUAL_S = 0.06
_NEARER_S = 0.02
"""A speed that is not punctual is taken for another only if it is nearer by so much."""
_SAME_RATIO = 1.01
_USED_SHARE = 0.93
"""A leg on which less than this of its speed was flown is no sooner at a higher one."""
_BOLD_SHARE, _SLOW_SHARE = 0.75, 0.5
"""Where less speed makes a leg no longer, it takes much less to; with half of it the leg is what it is."""
_SHORTEST_S = 0.05
_SLOPES = (-4.0, -0.25)
_PATIENCE_S = 30.0


@dataclass(frozen=True, slots=True)
class _Trial:
    """A leg flown at a speed: the copter as the next is to begin, where it was, and how late that is.

    ``used_m_s`` is what was flown of the speed, less where curves or the leg's length allow no more.
    """

    speed_m_s: float
    used_m_s: float
    copter: Copter
    positions: list[float]
    late_s: float


class SpeedSearch:
    """One pass over the legs of a draft; ``steps`` counts the model's steps that it took."""

    def __init__(
        self, plan: Schedule, caps_m_s: Floats, limits: Limits, step_s: float, takeoff: Takeoff
    ) -> None:
        """Begin.

        Args:
            plan: the draft, at least two places, and when each place ought to be left.
            caps_m_s: highest speed of each leg (n,).
            limits: what the vehicle may do.
            step_s: duration of the model's steps.
            takeoff: where the vehicle comes from.
        """
        self._plan, self._caps_m_s, self._limits, self._step_s = plan, caps_m_s, limits, step_s
        self._leave_s = plan.leave_s.round(DECIMALS)
        self._slowest_m_s = slowest_m_s(plan.draft)
        self._guesses = with_every_speed(plan.draft).speed_m_s
        fastest = replace(plan.draft, speed_m_s=caps_m_s)
        self._items, self._seqs = items_of(fastest, limits, every_speed=True)
        self._copter = copter_after_takeoff(plan.draft, limits, step_s, takeoff)
        self._copter.start_auto(self._items)
        self._positions = [*self._copter.position_m]
        self._steep = steep_legs(plan.draft.places_m)
        self._begin_s = 0.0
        self.steps = 0

    def run(self) -> SimulatedDraft:
        """The draft's flight at the speeds with which its places are left as nearly as can be on time."""
        self._positions += self._fly(self._copter, 0, _PATIENCE_S)
        self._begin_s = self._copter.time_s
        speeds = np.full(len(self._plan.draft), np.nan)
        for place in range(1, len(speeds)):
            guess_m_s = self._guesses[place] if isfinite(self._guesses[place]) else speeds[place - 1]
            best = self._best(place, float(guess_m_s))
            speeds[place] = best.speed_m_s
            self._copter = best.copter
            self._positions += best.positions
        return self._flight(speeds)

    def _flight(self, speeds: Floats) -> SimulatedDraft:
        """The flight when the last place is reached."""
        self._positions += positions_to_end(self._copter)
        return flight_of(with_speeds(self._plan.draft, speeds), self._copter, self._seqs, self._positions)

    @property
    def _now_s(self) -> float:
        return self._copter.time_s - self._begin_s

    def _best(self, place: int, guess_m_s: float) -> _Trial:
        """The speed that ends a leg nearest to when it ought to end; rather the guess than another."""
        low, high = float(self._slowest_m_s[place]), float(self._caps_m_s[place])
        speed = min(guess_m_s, high) if isfinite(guess_m_s) else high
        best: _Trial | None = None
        trials: list[_Trial] = []
        for _ in range(_MOST_TRIALS):
            trial = self._tried(copter_copy(self._copter), place, speed)
            trials.append(trial)
            if best is None or abs(trial.late_s) < abs(best.late_s) - _NEARER_S:
                best = trial
            if trial.late_s > 0:
                low = max(low, speed)
            else:
                high = min(high, speed)
            if _settled(trials) or high <= low * _SAME_RATIO:
                break
            speed = self._next_speed(place, trials[-2:], low, high)
        assert best is not None, "there are trials"
        return best

    def _tried(self, copter: Copter, place: int, speed_m_s: float) -> _Trial:
        at = self._seqs[place] - 2  # The speed's item, just before the place's.
        speed = round(speed_m_s, 2)
        self._items[at] = replace(self._items[at], params=(1.0, speed, 0.0, 0.0))
        if self._steep[place]:
            leg_m = self._plan.draft.places_m[place - 1 : place + 1]
            climb_m_s = float(leg_climbs_m_s(leg_m, np.array([np.nan, speed]), self._limits)[1])
            self._items[at - 1] = climb_item(self._seqs[place] - 2, climb_m_s)
        leave_s = float(self._leave_s[place])
        positions = self._fly(copter, place, 3 * max(leave_s - self._now_s, 0.0) + _PATIENCE_S)
        used_m_s = min(speed_m_s, self._top_speed_m_s(positions, climbs=bool(self._steep[place])))
        return _Trial(speed_m_s, used_m_s, copter, positions, passed_s(copter) - self._begin_s - leave_s)

    def _top_speed_m_s(self, positions: list[float], *, climbs: bool) -> float:
        """The highest ground speed of a leg; of one that ``climbs``, up or down if that is more."""
        highest_m = longest_step_m(positions)
        if climbs:
            highest_m = max(highest_m, float(np.abs(np.diff(positions[AXES - 1 :: AXES])).max(initial=0.0)))
        return max(highest_m / self._step_s, SLOWEST_M_S)

    def _next_speed(self, place: int, trials: list[_Trial], low: float, high: float) -> float:
        """The speed at which a leg would end on time if its duration went with a power of it."""
        wanted_s = self._moving_s(place, 0.0)
        durations = [self._moving_s(place, trial.late_s) for trial in trials]
        slope = -1.0
        if len(trials) > 1 and abs(log(durations[1] / durations[0])) > 1e-3:
            slope = log(trials[1].used_m_s / trials[0].used_m_s) / log(durations[1] / durations[0])
        slope = min(max(slope, _SLOPES[0]), _SLOPES[1])
        speed = float(trials[-1].used_m_s * (wanted_s / durations[-1]) ** slope)
        if len(trials) > 1 and trials[0].late_s == trials[1].late_s:
            speed = min(speed, _BOLD_SHARE * trials[-1].used_m_s)
        if low < speed < high:
            return speed
        if len(trials) > 1:
            return float((low * high) ** 0.5)
        return high if speed >= high else low

    def _moving_s(self, place: int, late_s: float) -> float:
        """How long a leg takes that ends so late, waiting not counted."""
        hold_s = float(self._plan.draft.hold_s[place])
        return max(float(self._leave_s[place]) + late_s - hold_s - self._now_s, _SHORTEST_S)

    def _fly(self, copter: Copter, place: int, most_s: float) -> list[float]:
        """Where a copter is after each step until the leg to a place is about to end, or for so long."""
        positions = positions_on_leg(copter, self._seqs[place], int(most_s / self._step_s))
        self.steps += len(positions) // AXES
        return positions


def _settled(trials: list[_Trial]) -> bool:
    """Whether no other speed comes nearer: the leg is on time, or takes as long at any."""
    last = trials[-1]
    if abs(last.late_s) <= _PUNCTUAL_S:
        return True
    same = len(trials) > 1 and last.late_s == trials[-2].late_s
    if last.late_s > 0:
        return same or last.used_m_s < _USED_SHARE * last.speed_m_s
    return same and last.speed_m_s < _SLOW_SHARE * trials[0].used_m_s

"""A draft flown in parts: from where a leg begins, over a few legs, as often as is wanted.

A change of one leg is judged by the legs around it, in a fraction of the time of a whole flight. What
came before is kept: copies of the copter as each leg began fly on from there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.errors import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.legs.copter_snapshot import CopterSnapshot
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.simulated_draft import climbing_copter, items_of
from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.mission.local_items import LocalItem


@dataclass(frozen=True, slots=True, eq=False)
class LocalFlight:
    """Where the vehicle was on some legs: times (k,) from reaching the first place, and places (k, 2)."""

    time_s: Floats
    north_east_m: Floats


class LocalFlights:
    """A draft's flight as far as it is needed, and what a few legs of others like it would be.

    ``steps`` counts the model's steps.
    """

    def __init__(self, problem: FitProblem, draft: Draft, most_s: float) -> None:
        """Begin; legs that take longer than ``most_s`` do not end."""
        self._problem, self._draft = problem, with_every_speed(draft) if problem.timed else draft
        self._most_steps = most_s / problem.step_s
        self.steps = 0
        items, self._seqs = self._items_of(self._draft)
        copter = climbing_copter(draft, problem.limits, problem.step_s, problem.recording.home_amsl_m)
        copter.start_auto(items)
        # How the copter is one step before the leg to each place begins.
        self._before = [self._snapshot(copter, items)]
        self._begin_s = 0.0
        self._fly_on()
        self._begin_s = self._before[1].copy(self._shared(items)).time_s

    @property
    def draft(self) -> Draft:
        """What is flown."""
        return self._draft

    def change(self, draft: Draft, first: int) -> None:
        """Fly another draft, which differs in what is flown from the leg to place ``first`` on."""
        self._draft = draft
        del self._before[first + 1 :]

    def fly(self, draft: Draft, first: int, last: int) -> LocalFlight:
        """The legs to places ``first`` to ``last`` of a draft that is flown like this one before them.

        Raises:
            MissionError: they do not end.
        """
        while len(self._before) <= first:
            self._fly_on()
        items, _ = self._items_of(draft)
        copter = self._before[first].copy(self._shared(items))
        began_s = copter.time_s - self._begin_s
        rows = self._flown_past(copter, last)
        return LocalFlight(began_s + self._problem.step_s * np.arange(len(rows), dtype=float), np.array(rows))

    def _fly_on(self) -> None:
        """Find how the copter is before the next leg."""
        place = len(self._before) - 1
        items, _ = self._items_of(self._draft)
        steps = len(self._flown_past(self._before[place].copy(self._shared(items)), place)) - 1
        copter = self._before[place].copy(self._shared(items))
        for _ in range(steps - 1):
            copter.step()
        self._before.append(self._snapshot(copter, items))

    def _flown_past(self, copter: Copter, place: int) -> list[tuple[float, float]]:
        """Where a copter is until it is on the way to the place after, or at the end."""
        mission, seq = copter.mission, self._seqs[place]
        assert mission is not None, "a draft is flown in AUTO"
        most_steps = copter.steps + self._most_steps
        rows = [copter.position_m[:2]]
        while not mission.completed and (mission.seq is None or mission.seq <= seq):
            copter.step()
            rows.append(copter.position_m[:2])
            if copter.steps > most_steps:
                raise MissionError("a leg of the fitted flight does not end")
        self.steps += len(rows)
        return rows

    def _items_of(self, draft: Draft) -> tuple[list[LocalItem], list[int]]:
        return items_of(draft, every_speed=self._problem.timed)

    def _shared(self, items: list[LocalItem]) -> tuple[object, ...]:
        return items, self._problem.limits

    def _snapshot(self, copter: Copter, items: list[LocalItem]) -> CopterSnapshot:
        return CopterSnapshot(copter, self._shared(items))


def with_every_speed(draft: Draft) -> Draft:
    """The draft with the speed of each leg said, but for the first, also where it goes on as before."""
    speeds = draft.speed_m_s.copy()
    for place in range(2, len(speeds)):
        if np.isnan(speeds[place]):
            speeds[place] = speeds[place - 1]
    return replace(draft, speed_m_s=speeds)

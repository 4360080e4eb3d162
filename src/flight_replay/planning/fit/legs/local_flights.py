"""A draft flown in parts: from where a leg begins, over a few legs, as often as is wanted.

A change of one leg is judged by the legs around it, in a fraction of the time of a whole flight. What
came before is kept: copies of the copter as each leg began fly on from there.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.simulated_draft import (
    copter_after_takeoff,
    items_changed,
    items_of,
    places_of,
)
from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.flight.copter_copy import copter_copy
from flight_replay.simulator.flight.flown_positions import (
    AXES,
    passed_s,
    positions_after,
    positions_on_leg,
)
from flight_replay.simulator.mission.local_items import LocalItem

_FOLLOWS_S = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class LocalFlight:
    """Where the vehicle was on some legs: times (k,) from reaching the first place, and places (k, 3).

    The first ``ended`` of them are on those legs. The rest are the second after, in which the vehicle comes
    to where its target has been. ``passed_s`` is when the target passed the place of each leg, to a
    fraction of a step.
    """

    time_s: Floats
    place_m: Floats
    ended: int
    passed_s: Floats

    @property
    def north_east_m(self) -> Floats:
        """The places over the ground (k, 2)."""
        return self.place_m[:, :2]

    @property
    def left_s(self) -> float:
        """When the target left the last of the places."""
        return float(self.time_s[self.ended - 1])


@dataclass(frozen=True, slots=True, eq=False)
class _Leg:
    """Where the copter was after each step of a leg (``flown``) and of the second after it (``after``).

    ``left_s`` is when the target left the leg's place, in whole steps, ``passed_s`` when it passed that
    place, to a fraction of a step.
    """

    flown: list[float]
    after: list[float]
    left_s: float
    passed_s: float


class LocalFlights:
    """A draft's flight as far as it is needed, and what a few legs of others like it would be.

    ``steps`` counts the model's steps.
    """

    def __init__(self, problem: FitProblem, draft: Draft, most_s: float) -> None:
        """Begin; legs that take longer than ``most_s`` do not end."""
        self._problem, self._draft = problem, with_every_speed(draft) if problem.timed else draft
        self._most_steps = most_s / problem.step_s
        self.steps = 0
        self._items, self._seqs = items_of(self._draft, problem.limits, every_speed=problem.timed)
        copter = copter_after_takeoff(draft, problem.limits, problem.step_s, problem.recording.takeoff)
        copter.start_auto(self._items)
        # The copter as the leg to each place is about to begin, and what it flew on each leg before.
        self._before = [copter]
        self._legs: list[_Leg] = []
        self._begin_s = 0.0
        self._fly_on()
        self._begin_s = self._legs[0].left_s

    @property
    def draft(self) -> Draft:
        """What is flown."""
        return self._draft

    def change(self, draft: Draft, first: int) -> None:
        """Fly another draft, which differs in what is flown from the leg to place ``first`` on."""
        self._draft, self._items = draft, self._items_of(draft)
        del self._before[first + 1 :]
        del self._legs[first:]

    def left_s(self, place: int) -> float:
        """When the draft's target leaves a place, counted from the first."""
        while len(self._legs) <= place:
            self._fly_on()
        return self._legs[place].left_s - self._begin_s

    def fly(self, draft: Draft, first: int, last: int) -> LocalFlight:
        """The legs to places ``first`` to ``last`` of a draft that is flown like this one before them.

        Args:
            draft: what to fly.
            first: the first of the places.
            last: the last of the places.

        Raises:
            MissionError: they do not end.
        """
        while len(self._before) <= first:
            self._fly_on()
        if draft is self._draft:
            return self._flown_already(first, last)
        copter = copter_copy(self._before[first], self._items_of(draft))
        positions, passed = [*copter.position_m], []
        for place in range(first, last + 1):
            positions += self._flown_to(copter, place)
            passed.append(passed_s(copter))
        return self._flight(first, positions, self._run_on(copter), passed)

    def _flown_already(self, first: int, last: int) -> LocalFlight:
        """The same for the draft that is flown, from what is known of its legs."""
        self.left_s(last)
        legs = self._legs[first : last + 1]
        began_m = self._legs[first - 1].flown[-AXES:]
        positions = [*began_m, *chain.from_iterable(leg.flown for leg in legs)]
        return self._flight(first, positions, legs[-1].after, [leg.passed_s for leg in legs])

    def _flight(
        self, first: int, flown: list[float], after: list[float], passed_s: list[float]
    ) -> LocalFlight:
        place_m = places_of(flown + after)
        times_s = self.left_s(first - 1) + self._problem.step_s * np.arange(len(place_m), dtype=float)
        return LocalFlight(times_s, place_m, len(flown) // AXES, np.array(passed_s) - self._begin_s)

    def _run_on(self, copter: Copter) -> list[float]:
        """Where a copter is after each step of the time in which it follows its target."""
        positions = positions_after(copter, round(_FOLLOWS_S / self._problem.step_s))
        self.steps += len(positions) // AXES
        return positions

    def _fly_on(self) -> None:
        """Find what is flown on the next leg, and how the copter is after it."""
        copter = copter_copy(self._before[-1], self._items)
        positions = self._flown_to(copter, len(self._legs))
        self._before.append(copter_copy(copter))
        left_s, passed = copter.time_s, passed_s(copter)
        self._legs.append(_Leg(positions, self._run_on(copter), left_s, passed))

    def _flown_to(self, copter: Copter, place: int) -> list[float]:
        """Where a copter is after each step until the leg to a place is about to end."""
        positions = positions_on_leg(copter, self._seqs[place], self._most_steps)
        steps = len(positions) // AXES
        self.steps += steps
        if steps >= self._most_steps:
            raise MissionError("a leg of the fitted flight does not end")
        return positions

    def _items_of(self, draft: Draft) -> list[LocalItem]:
        return items_changed(self._items, self._seqs, self._draft, draft, self._problem.limits)

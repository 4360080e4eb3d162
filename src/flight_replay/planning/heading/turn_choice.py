"""Which legs to turn the vehicle on, and how: a beam search over the legs in order.

A leg without an item costs what the vehicle's own heading is off; a leg with items costs what is left,
and ``worth_deg_s`` an item. What a leg ends with is where the next one begins, so that several
beginnings are kept of every leg.

A turn goes on from where the heading is only if it is the first item of its leg
(``simulator/flight/auto_do_commands.py``); behind a speed change it begins with the path's heading. But
a speed that rises once its leg has begun comes too late: the end of that leg is planned with the old
one (``AC_WPNav::set_spline_destination``). So it rises as the leg before ends, behind its turns, and once
more behind the first turn of its own leg, should that have been missed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.mission.items import MissionItem, keep_heading, wait_until_near
from flight_replay.planning.heading.legs import SAMPLE_S, Leg
from flight_replay.planning.heading.turns import Response, Turns, followed_deg, knots

KEPT = 6
"""Beginnings of a leg that are kept: 12 lower the error by less than 0.2 degrees."""
EARLY_S = 0.3
"""How long before the end of a leg the speed rises for the next: legs differ by a tenth from the model's."""
_SAME_DEG = 6.0
_MOST_TURNS = 4
_TOLERANCE_DEG = 2.0
_SHARES = (0.25, 0.5, 0.75)


class Shifts(IntEnum):
    """Which changes of speed may come later, or sooner, than planned, so that a turn can go on."""

    NONE = 0
    FALLING = 1
    ALL = 2


@dataclass(frozen=True, slots=True)
class LegItems:
    """Items of a leg: ``first`` before the DO items that it has already, ``then`` after them.

    ``early`` is whether the DO items of the next leg start behind them, too.
    """

    first: tuple[MissionItem, ...] = ()
    then: tuple[MissionItem, ...] = ()
    early: bool = False

    @property
    def shifts(self) -> tuple[bool, bool]:
        """Whether the DO items of this leg start later, and those of the next one sooner."""
        return bool(self.first), self.early

    def __len__(self) -> int:
        return len(self.first) + len(self.then) + self.early


@dataclass(frozen=True, slots=True)
class Choice:
    """What is asked on the legs so far, what it costs, and the heading and its target at the end.

    ``own`` is whether the vehicle turns its own way there.
    """

    legs: tuple[LegItems, ...]
    cost_deg_s: float
    heading_deg: float
    target_deg: float
    own: bool = True

    @property
    def early(self) -> bool:
        """Whether the DO items of the next leg have started already."""
        return bool(self.legs) and self.legs[-1].early


def best_items(
    legs: Sequence[Leg],
    response: Response,
    worth_deg_s: float,
    shifts: Shifts = Shifts.NONE,
    like: Sequence[LegItems] | None = None,
) -> tuple[LegItems, ...]:
    """The items to add to each leg.

    Args:
        legs: at least one.
        response: how the vehicle turns.
        worth_deg_s: how much an item must lower the error, degrees times seconds.
        shifts: which changes of speed may be shifted.
        like: items that shift the same changes of speed; None where that does not matter.
    """
    choices = [Choice((), 0.0, 0.0, 0.0)]
    for k, leg in enumerate(legs):
        early = shifts >= Shifts.ALL and k + 1 < len(legs) and legs[k + 1].rises
        found = [
            after
            for choice in choices
            for after in _LegSearch(choice, leg, response, worth_deg_s, shifts).choices(early=early)
        ]
        alike = found if like is None else [each for each in found if each.legs[-1].shifts == like[k].shifts]
        choices = _distinct(alike or found)
    return choices[0].legs


def _distinct(choices: list[Choice]) -> list[Choice]:
    """The cheapest choices, none of which ends like a cheaper one."""
    kept: dict[tuple[bool, bool, int], Choice] = {}
    for choice in sorted(choices, key=lambda choice: choice.cost_deg_s):
        kept.setdefault((choice.own, choice.early, round(choice.target_deg % 360.0 / _SAME_DEG)), choice)
        if len(kept) == KEPT:
            break
    return list(kept.values())


class _LegSearch:
    """The ways to go on from a choice along a leg."""

    def __init__(
        self, choice: Choice, leg: Leg, response: Response, worth_deg_s: float, shifts: Shifts
    ) -> None:
        self._choice, self._leg, self._response = choice, leg, response
        self._worth_deg_s, self._shifts = worth_deg_s, shifts
        self._early_m = float(np.interp(leg.duration_s - EARLY_S, leg.time_s, leg.left_m))
        known = np.isfinite(leg.wanted_deg)
        # When the target has to be where, for the vehicle to be where wanted one lag later.
        self._ahead_deg = (
            np.interp(leg.time_s + response.lag_s, leg.time_s[known], leg.wanted_deg[known])
            if known.any()
            else None
        )

    def choices(self, *, early: bool) -> Iterator[Choice]:
        """The vehicle's own way, and turned; ``early``: also with the next leg's items at the end."""
        leg = self._leg
        yield replace(self._after(LegItems(), leg.own_deg), own=True)
        for first, begin in self._beginnings():
            for turns in self._turned(begin, leg.duration_s):
                if first or turns.items:
                    yield self._fixed(LegItems(first, tuple(turns.items)), turns)
            if early:
                for turns in self._turned(begin, leg.duration_s - EARLY_S):
                    if turns.end_s <= leg.duration_s - EARLY_S + SAMPLE_S and (turns.items or first):
                        turns.items.append(wait_until_near(round(self._early_m, 2)))
                        yield self._fixed(LegItems(first, tuple(turns.items), early=True), turns)

    def _beginnings(self) -> Iterator[tuple[tuple[MissionItem, ...], tuple[float, float]]]:
        """Items to begin with, and target and time that turns then begin from."""
        choice, leg = self._choice, self._leg
        own_deg = float(leg.own_deg[0])
        own_deg = choice.heading_deg if np.isnan(own_deg) else own_deg
        yield (), (own_deg if leg.has_items else choice.target_deg, 0.0)
        shifted = choice.early or (self._shifts >= Shifts.FALLING and not leg.rises)
        if leg.has_items and not choice.own and shifted:
            behind_deg = choice.target_deg - choice.heading_deg
            settling_s = self._response.settling_s(behind_deg / self._response.lag_s)
            yield (keep_heading(),), (choice.target_deg, settling_s)

    def _turned(self, begin: tuple[float, float], until_s: float) -> Iterator[Turns]:
        """Turns to try from a target and time on, to be done by a time."""
        yield Turns(self._response, *begin)
        times_s, ahead_deg = self._leg.time_s, self._ahead_deg
        last = int(np.searchsorted(times_s, until_s + 1e-6, side="right")) - 1
        if ahead_deg is None or last < 1:
            return
        times_s, ahead_deg = times_s[: last + 1], ahead_deg[: last + 1]
        for chosen in knots(times_s, ahead_deg, _MOST_TURNS, _TOLERANCE_DEG):
            yield self._through(begin, times_s[chosen], ahead_deg[chosen])
        for share in _SHARES:
            at = int(share * last)
            for heading_deg in {float(ahead_deg[at]), float(np.median(ahead_deg[at:]))}:
                yield self._through(begin, times_s[at : at + 1], np.array([heading_deg]))

    def _through(self, begin: tuple[float, float], times_s: Floats, headings_deg: Floats) -> Turns:
        turns = Turns(self._response, *begin)
        for time_s, heading_deg in zip(times_s.tolist(), headings_deg.tolist(), strict=True):
            turns.turn(heading_deg, time_s)
        return turns

    def _fixed(self, items: LegItems, turns: Turns) -> Choice:
        return self._after(items, turns.targets_deg(self._leg.time_s))

    def _after(self, items: LegItems, targets_deg: Floats) -> Choice:
        """The choice at the end of the leg, if the target is there (n,) meanwhile."""
        choice, leg = self._choice, self._leg
        headings = followed_deg(choice.heading_deg, targets_deg, SAMPLE_S, self._response)
        off = np.abs((headings - leg.wanted_deg + 180.0) % 360.0 - 180.0)
        cost = float(np.nansum(off[:-1])) * SAMPLE_S + self._worth_deg_s * len(items)
        heading, target = float(headings[-1]), float(targets_deg[-1])
        ends = heading, heading if np.isnan(target) else target
        return Choice((*choice.legs, items), choice.cost_deg_s + cost, *ends, own=False)

"""Which legs to turn the vehicle on, and how: a beam search over the legs in order.

A leg without an item costs what the vehicle's heading is off by itself; a leg with items costs what is
left, and ``worth_deg_s`` an item. What a leg ends with is where the next one begins, so that several
beginnings are kept of every leg.

A turn goes on from where the heading is if it is the first item of its leg; behind a speed change it
begins with the path's heading, as the leg has taken that (``simulator/flight/auto_do_commands.py``). A
position that is faced when the leg before ends is faced on, so that a turn behind a speed change too
goes on from there: to keep a heading the vehicle faces a position far ahead of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.movement import turn_deg
from flight_replay.mission.items import MissionItem
from flight_replay.planning.heading.legs import SAMPLE_S, Leg
from flight_replay.planning.heading.turns import Response, Turns, followed_deg, knots

KEPT = 6
"""Beginnings of a leg that are kept: 12 lower the error by less than 0.2 degrees."""
EARLY_S = 0.3
"""How long before the end of a leg a position is faced: legs differ by a tenth from the model's."""
ROI_DISTANCE_M = 1000.0
"""Far enough for the bearing to stay while a leg is flown, near enough for a map."""
_SAME_DEG = 6.0
_LEAST_TURNS, _TURNS_A_S = 4, 0.5
"""The most knots of a leg, and how many more with its length: a step of 4 s has two."""
_MOST_ITEMS = 240
"""ArduCopter ends a mission with 255 items up to its next waypoint (AP_Mission::advance_current_nav_cmd)."""
_TOLERANCE_DEG = 2.0
_SHARES = (0.25, 0.5, 0.75)

Place = tuple[float, float]
"""North and east of the local frame, metres."""


@dataclass(frozen=True, slots=True)
class LegItems:
    """Items of a leg, behind those that it has already: turns, then ``roi_m``, the position to face."""

    turns: tuple[MissionItem, ...] = ()
    roi_m: Place | None = None

    def __len__(self) -> int:
        return len(self.turns) + (self.roi_m is not None)


@dataclass(frozen=True, slots=True)
class Choice:
    """What is asked on the legs so far, what it costs, and the heading and its target at the end.

    ``own`` is whether the vehicle turns its own way there, ``roi_m`` the position that it faces, if any.
    """

    legs: tuple[LegItems, ...] = ()
    cost_deg_s: float = 0.0
    heading_deg: float = 0.0
    target_deg: float = 0.0
    own: bool = True
    roi_m: Place | None = None


def best_items(
    legs: Sequence[Leg], response: Response, worth_deg_s: float, *, may_face: bool = True
) -> tuple[LegItems, ...]:
    """The items to add to each leg.

    Args:
        legs: at least one.
        response: how the vehicle turns.
        worth_deg_s: how much an item must lower the error, degrees times seconds.
        may_face: whether the vehicle turns to positions that it is told to face.
    """
    choices = [Choice()]
    for leg in legs:
        search = _LegSearch(leg, response, worth_deg_s, may_face)
        choices = _distinct([after for choice in choices for after in search.choices(choice)])
    return choices[0].legs


def _distinct(choices: list[Choice]) -> list[Choice]:
    """The cheapest choices, none of which ends like a cheaper one."""
    kept: dict[tuple[bool, bool, int], Choice] = {}
    for choice in sorted(choices, key=lambda choice: choice.cost_deg_s):
        ends = choice.own, choice.roi_m is None, round(choice.target_deg % 360.0 / _SAME_DEG)
        kept.setdefault(ends, choice)
        if len(kept) == KEPT:
            break
    return list(kept.values())


class _LegSearch:
    """The ways to go on along a leg."""

    def __init__(self, leg: Leg, response: Response, worth_deg_s: float, may_face: bool) -> None:
        self._leg, self._response = leg, response
        self._worth_deg_s, self._may_face = worth_deg_s, may_face
        known = np.isfinite(leg.wanted_deg)
        # When the target has to be where, for the vehicle to be where wanted one lag later.
        self._ahead_deg = (
            np.interp(leg.time_s + response.lag_s, leg.time_s[known], leg.wanted_deg[known])
            if known.any()
            else None
        )
        self._knots = {until_s: self._knots_of(until_s) for until_s in (leg.duration_s, self._facing_s)}

    @property
    def _facing_s(self) -> float:
        """When a position has to be faced."""
        return self._leg.duration_s - EARLY_S

    def choices(self, choice: Choice) -> Iterator[Choice]:
        """The vehicle's own way, or what it faces already; turned; and made to face a position."""
        yield self._without_items(choice)
        for turns in self._turned(self._begin_deg(choice), self._leg.duration_s):
            yield self._after(
                choice, LegItems(tuple(turns.items)), turns.targets_deg(self._leg.time_s), own=False
            )
        if self._may_face:
            yield from self._faced(choice)

    def _without_items(self, choice: Choice) -> Choice:
        if choice.roi_m is None:
            return self._after(choice, LegItems(), self._leg.own_deg, own=True)
        bearings = self._bearings_deg(choice.roi_m, choice.target_deg)
        return self._after(choice, LegItems(), bearings, own=False, roi_m=choice.roi_m)

    def _begin_deg(self, choice: Choice) -> float:
        """The target that the first turn begins from."""
        own_deg = float(self._leg.own_deg[0])
        if choice.roi_m is not None or not self._leg.has_items:
            return choice.target_deg
        return choice.heading_deg if np.isnan(own_deg) else own_deg

    def _faced(self, choice: Choice) -> Iterator[Choice]:
        """Faced from the beginning; or behind turns, which must be done before the leg ends."""
        leg, until_s, begin_deg = self._leg, self._facing_s, self._begin_deg(choice)
        plain = [Turns(self._response, heading) for heading in self._headings_deg()]
        for turns in (*plain, *self._turned(begin_deg, until_s)):
            if turns.end_s > until_s:
                continue
            at = int(np.searchsorted(leg.time_s, turns.end_s))
            roi_m = _far_place(leg.north_east_m[at], turns.target_deg[-1])
            targets = turns.targets_deg(leg.time_s)
            targets[at:] = self._bearings_deg(roi_m, turns.target_deg[-1])[at:]
            yield self._after(choice, LegItems(tuple(turns.items), roi_m), targets, own=False, roi_m=roi_m)

    def _headings_deg(self) -> set[float]:
        """Headings to try for a whole leg."""
        ahead_deg = self._ahead_deg
        if ahead_deg is None:
            return set()
        last = len(ahead_deg) - 1
        places = (ahead_deg[round(share * last)] for share in (0.0, *_SHARES, 1.0))
        return {*map(float, places), float(np.median(ahead_deg))}

    def _bearings_deg(self, place_m: Place, near_deg: float) -> Floats:
        """The bearings of a place (n,), without jumps, near a heading at first."""
        north, east = (np.asarray(place_m) - self._leg.north_east_m).T
        bearings = np.degrees(np.unwrap(np.arctan2(east, north)))
        shift: Floats = bearings + round((near_deg - bearings[0]) / 360.0) * 360.0
        return shift

    def _turned(self, begin_deg: float, until_s: float) -> Iterator[Turns]:
        """Turns to try from a target on, to be done by a time; from the wanted heading on, too."""
        times_s, ahead_deg, last = self._leg.time_s, self._ahead_deg, self._last(until_s)
        if ahead_deg is None or last < 1:
            return
        for chosen in self._knots[until_s]:
            for places in [chosen] if len(chosen) == 1 else [chosen, [0, *chosen]]:
                turns = self._through(begin_deg, times_s[places], ahead_deg[places])
                if len(turns.items) < _MOST_ITEMS:
                    yield turns
        ahead_deg = ahead_deg[: last + 1]
        for share in _SHARES:
            at = int(share * last)
            for heading_deg in {float(ahead_deg[at]), float(np.median(ahead_deg[at:]))}:
                yield self._through(begin_deg, times_s[at : at + 1], np.array([heading_deg]))

    def _knots_of(self, until_s: float) -> list[list[int]]:
        """Knots of the wanted headings until a time, ever more."""
        times_s, last = self._leg.time_s, self._last(until_s)
        if self._ahead_deg is None or last < 1:
            return []
        most = min(_LEAST_TURNS + int(_TURNS_A_S * until_s), _MOST_ITEMS)
        return knots(times_s[: last + 1], self._ahead_deg[: last + 1], most, _TOLERANCE_DEG)

    def _last(self, until_s: float) -> int:
        """The last sample until a time."""
        return int(np.searchsorted(self._leg.time_s, until_s + 1e-6, side="right")) - 1

    def _through(self, begin_deg: float, times_s: Floats, headings_deg: Floats) -> Turns:
        turns = Turns(self._response, begin_deg)
        for time_s, heading_deg in zip(times_s.tolist(), headings_deg.tolist(), strict=True):
            turns.turn(heading_deg, time_s)
        return turns

    def _after(
        self, choice: Choice, items: LegItems, targets_deg: Floats, *, own: bool, roi_m: Place | None = None
    ) -> Choice:
        """The choice at the end of the leg, if the target is there (n,) meanwhile."""
        leg = self._leg
        headings = followed_deg(choice.heading_deg, targets_deg, SAMPLE_S, self._response)
        off = np.abs(turn_deg(headings, leg.wanted_deg))
        cost = float(np.nansum(off[:-1])) * SAMPLE_S + self._worth_deg_s * len(items)
        heading, target = float(headings[-1]), float(targets_deg[-1])
        target = heading if np.isnan(target) else target
        return Choice((*choice.legs, items), choice.cost_deg_s + cost, heading, target, own, roi_m)


def _far_place(north_east_m: Floats, heading_deg: float) -> Place:
    """The position to face for a heading."""
    north, east = north_east_m.tolist()
    angle = radians(heading_deg)
    return north + ROI_DISTANCE_M * cos(angle), east + ROI_DISTANCE_M * sin(angle)

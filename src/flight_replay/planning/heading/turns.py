"""How a vehicle answers to CONDITION_YAW items: what they ask, and the heading that comes of it.

ArduCopter 4.1 to 4.7 (AutoYaw::set_fixed_yaw, yaw_cd and reached_fixed_yaw_target in autoyaw.cpp):
the heading target moves to the angle at the rate, at most ATC_SLEW_YAW; the item is done when the
target is there and the vehicle within 2 degrees of it. The vehicle follows the target with
ATC_INPUT_TC's lag (AC_AttitudeControl::input_shaping_angle). ArduCopter 3.3 to 4.0 has no rate, and turns
as fast as it can, the short way (AutoYaw::set_fixed_yaw, yaw). What an item asked for holds until the next
waypoint's leg.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, isnan, log

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.movement import turn_deg
from flight_replay.mission.items import MissionItem, turn_to, wait
from flight_replay.simulator.dynamics.limits import Limits

_REACHED_DEG = 2.0
_SHORTEST_RAMP_S = 0.05
_LEAST_WAIT_S = 0.2
_SLOWEST_FIRST_DEG_S, _SLOWEST_DEG_S = 10.0, 0.5
_HELD_DEG = 2.0
_WIDE_DEG = 135.0
"""Turns this wide are told which way round: the short way may be the other one when they begin."""
_WIDEST_DEG = 170.0
"""The most of one item: ArduCopter up to 4.0 ignores the direction, and turns the short way."""
_AIRFRAME_LAG_S = 0.02
_BEHIND_LAGS, _SETTLING_LAGS = 1.9, 0.65
"""Fitted to turns of 45 to 120 degrees at 20 to 60 degrees a second: within 0.02 s, for errors add up."""


@dataclass(frozen=True, slots=True)
class Response:
    """How fast a vehicle turns, degrees a second, and how far behind its target it is, seconds."""

    fastest_deg_s: float
    lag_s: float

    @classmethod
    def of(cls, limits: Limits) -> Response:
        """The response of a vehicle of these limits."""
        return cls(float(np.degrees(limits.yaw_slew_rad_s)), limits.attitude_input_s + _AIRFRAME_LAG_S)

    def settling_s(self, rate_deg_s: float) -> float:
        """Time from the end of a turn at a rate until the vehicle is within 2 degrees."""
        behind_deg = _BEHIND_LAGS * abs(rate_deg_s) * self.lag_s
        settles = behind_deg > _REACHED_DEG
        return _SETTLING_LAGS * self.lag_s * log(behind_deg / _REACHED_DEG) if settles else 0.0


class Turns:
    """Items one after the other, and the heading target that comes of them.

    The target is on straight lines between points in time, ``time_s`` and ``target_deg``.
    """

    def __init__(self, response: Response, begin_deg: float) -> None:
        self._response = response
        self.items: list[MissionItem] = []
        self.time_s = [0.0]
        self.target_deg = [begin_deg]
        self._until_s = 0.0

    def turn(self, heading_deg: float, until_s: float) -> None:
        """Turn to a heading, so that this is done at a time, or as soon after as the vehicle can.

        A slow first turn is done sooner and waited after: it would take long where it begins with more
        to turn than expected. Later ones begin where the one before has ended. What is no turn is a wait.
        """
        change = turn_deg(heading_deg, self.target_deg[-1])
        if self.items and abs(change) < _HELD_DEG:
            self._until_s = max(until_s, self._until_s)
            return
        slowest_deg_s = _SLOWEST_DEG_S if self.items else _SLOWEST_FIRST_DEG_S
        self.wait_until(self._until_s)
        left_s = max(until_s - self.end_s, _SHORTEST_RAMP_S)
        response = self._response
        settling_s = response.settling_s(min(abs(change) / left_s, response.fastest_deg_s))
        rate = abs(change) / max(left_s - settling_s, _SHORTEST_RAMP_S)
        rate = min(max(rate, slowest_deg_s), response.fastest_deg_s)
        direction = 0 if abs(change) < _WIDE_DEG else 1 if change > 0 else -1
        self.items.append(turn_to(round(heading_deg % 360.0, 1), round(rate, 2), direction))
        self._go_on(change, abs(change) / rate)
        self._go_on(0.0, response.settling_s(rate))
        self._until_s = until_s

    def wait_until(self, time_s: float) -> None:
        """Do nothing more until a time, if that is worth an item."""
        if time_s > self.end_s + _LEAST_WAIT_S:
            if not self.items:
                self.turn(self.target_deg[-1], self.end_s)
            self.items.append(wait(round(time_s - self.end_s, 2)))
            self._go_on(0.0, time_s - self.end_s)

    def _go_on(self, change_deg: float, duration_s: float) -> None:
        if duration_s > 0:
            self.time_s.append(self.end_s + duration_s)
            self.target_deg.append(self.target_deg[-1] + change_deg)

    def targets_deg(self, times_s: Floats) -> Floats:
        """The heading targets (n,) at times since the leg began."""
        return np.interp(times_s, self.time_s, self.target_deg)

    @property
    def end_s(self) -> float:
        """When the last item is done."""
        return self.time_s[-1]


def followed_deg(begin_deg: float, targets_deg: Floats, step_s: float, response: Response) -> Floats:
    """Headings (n,) of a vehicle that follows targets as fast as it can turn, one lag behind.

    Args:
        begin_deg: its heading at first.
        targets_deg: the heading targets (n,), at equal times; where one is not a number, the heading stays.
        step_s: time between them.
        response: how it turns.
    """
    most, share = response.fastest_deg_s * step_s, min(step_s / response.lag_s, 1.0)
    headings, heading = [], begin_deg
    for target in targets_deg.tolist():
        headings.append(heading)
        # Written out: with turn_deg, max and min the headings of a hover would take three times as long.
        step = share * ((target - heading + 180.0) % 360.0 - 180.0)
        if not isnan(step):
            heading += most if step > most else -most if step < -most else step
    return np.array(headings)


def knots(times_s: Floats, headings_deg: Floats, most: int, tolerance_deg: float) -> list[list[int]]:
    """Indices of ever more knots, the last sample always one, of lines that follow headings ever closer.

    A knot is added where the lines are farthest off, until that is within the tolerance. A list is a third
    longer than the one before, or the last. Wide turns are parted, so that each takes the short way.

    Args:
        times_s: (n,), rising.
        headings_deg: (n,), without jumps.
        most: most knots, besides those that part wide turns.
        tolerance_deg: how far off is close enough.
    """
    chosen = [0, len(times_s) - 1]
    found = [chosen]
    while len(chosen) <= most:
        off_deg = np.abs(headings_deg - np.interp(times_s, times_s[chosen], headings_deg[chosen]))
        worst = int(np.argmax(off_deg))
        if off_deg[worst] <= tolerance_deg:
            break
        chosen = sorted({*chosen, worst})
        found.append(chosen)
    return [_parted(each, headings_deg) for each in _ever_longer(found)]


def _parted(chosen: list[int], headings_deg: Floats) -> list[int]:
    """The knots but for the first, with more of them where the heading turns too far for one item."""
    parted = []
    for begin, end in pairwise(chosen):
        change_deg = headings_deg[end] - headings_deg[begin]
        turned = (headings_deg[begin : end + 1] - headings_deg[begin]) * np.sign(change_deg)
        parts = ceil(abs(change_deg) / _WIDEST_DEG)
        parted += [begin + int(np.argmax(turned >= abs(change_deg) * k / parts)) for k in range(1, parts)]
        parted.append(end)
    return parted


def _ever_longer(lists: list[list[int]]) -> list[list[int]]:
    """The first and the last of lists, and those between that are a third longer than the one kept before."""
    kept = lists[:1]
    for each in lists[1:]:
        if each is lists[-1] or 3 * (len(each) - 1) >= 4 * (len(kept[-1]) - 1):
            kept.append(each)
    return kept

"""How a vehicle answers to CONDITION_YAW items: what they ask, and the heading that comes of it.

ArduCopter 4.1 to 4.7 (AutoYaw::set_fixed_yaw, yaw_cd and reached_fixed_yaw_target in autoyaw.cpp):
the heading target moves to the angle at the rate, at most ATC_SLEW_YAW; the item is done when the
target is there and the vehicle within 2 degrees of it. The vehicle follows the target with
ATC_INPUT_TC's lag (AC_AttitudeControl::input_shaping_angle). ArduCopter 3.3 has no rate, and turns as fast
as it can (set_auto_yaw_look_at_heading). What an item asked for holds until the next waypoint's leg.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan, log

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.movement import turn_deg
from flight_replay.mission.items import MissionItem, turn_to, wait
from flight_replay.simulator.dynamics.limits import Limits

_REACHED_DEG = 2.0
_SHORTEST_RAMP_S = 0.05
_LEAST_WAIT_S = 0.2
_SLOWEST_DEG_S = 10.0
_WIDE_DEG = 135.0
"""Turns this wide are told which way round: the short way may be the other one when they begin."""
_AIRFRAME_LAG_S = 0.02


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
        behind_deg = abs(rate_deg_s) * self.lag_s
        return self.lag_s * log(behind_deg / _REACHED_DEG) if behind_deg > _REACHED_DEG else 0.0


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

        Slow turns are done sooner and waited after: they would take long where they begin with more
        to turn than expected.
        """
        self.wait_until(self._until_s)
        change = turn_deg(heading_deg, self.target_deg[-1])
        left_s = max(until_s - self.end_s, _SHORTEST_RAMP_S)
        response = self._response
        settling_s = response.settling_s(min(abs(change) / left_s, response.fastest_deg_s))
        rate = abs(change) / max(left_s - settling_s, _SHORTEST_RAMP_S)
        rate = min(max(rate, _SLOWEST_DEG_S), response.fastest_deg_s)
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
        if not isnan(target):
            heading += max(min(share * turn_deg(target, heading), most), -most)
    return np.array(headings)


def knots(times_s: Floats, headings_deg: Floats, most: int, tolerance_deg: float) -> list[list[int]]:
    """Indices of 1, 2, ... knots, the last sample always one, of lines that follow headings ever closer.

    Each list has one more knot, where the lines are farthest off, until that is within the tolerance.

    Args:
        times_s: (n,), rising.
        headings_deg: (n,), without jumps.
        most: most knots.
        tolerance_deg: how far off is close enough.
    """
    chosen = [0, len(times_s) - 1]
    found = [chosen[1:]]
    while len(found) < most:
        lines = np.interp(times_s, times_s[chosen], headings_deg[chosen])
        worst = int(np.argmax(np.abs(headings_deg - lines)))
        if abs(headings_deg[worst] - lines[worst]) <= tolerance_deg:
            break
        chosen = sorted({*chosen, worst})
        found.append(chosen[1:])
    return found

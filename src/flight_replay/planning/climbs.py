"""Heights that a vehicle can climb and descend over time, as near as possible to those recorded.

Where a recording climbs faster than the vehicle, a vehicle that only follows is late all the way up. Here it
starts sooner and ends later: the heights have the smallest sum of squared differences from the recorded
ones among all that keep climb rate, descent rate and vertical acceleration. The problem is convex; it is
solved by the alternating direction method of multipliers (Boyd et al., 2011), whose linear step is a
division in Fourier space for heights that are mirrored at both ends: a mission begins and ends level.

A vehicle that is on its way has little of its vertical acceleration: a spline's speed is such that it curves
upwards and downwards with no more than half of ``WPNAV_ACCEL_Z``, and the curve through a few waypoints is
less even than the recorded one. Each small bump in the heights would hold it up.
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.simulator.dynamics.limits import Limits

_STEP_S = 0.5
_MOST_STEPS = 20_000
_ROUNDS, _ROUNDS_A_CHECK = 1_000, 25
_RELAXATION = 1.6
_RATE_WEIGHT, _ACCEL_WEIGHT, _FLOOR_WEIGHT = 16.0, 10.0, 1.0
"""Penalties for breaking a limit; they decide only how fast the heights converge."""
_SETTLED_M, _CHANGED_M = 1e-3, 0.02
_TOLERANCE = 0.02
"""Rates and accelerations may exceed their limits by so much, m/s and m/s²."""
_STANDING_M_S, _FLYING_M_S, _FLYING_SHARE = 1.0, 4.0, 0.2
"""Slower than the first a vehicle has all of its vertical acceleration, faster than the second a share."""


def feasible_heights_m(
    time_s: Floats, height_m: Floats, speed_m_s: Floats, limits: Limits, floor_m: float
) -> Floats:
    """The heights (n,) nearest to ``height_m`` (n,) at which a vehicle of these limits can be in time.

    Args:
        time_s: times (n,), never falling.
        height_m: recorded heights, none below the floor.
        speed_m_s: recorded ground speeds (n,).
        limits: how fast the vehicle climbs, descends, and changes from the one to the other.
        floor_m: no height is below this.
    """
    duration_s = float(time_s[-1] - time_s[0])
    if duration_s <= 0:
        return height_m
    steps = int(np.clip(np.ceil(duration_s / _STEP_S), 2, _MOST_STEPS))
    grid_s = np.linspace(time_s[0], time_s[-1], steps + 1)
    on_grid_m = np.interp(grid_s, time_s, height_m)
    share = np.interp(
        np.interp(grid_s, time_s, speed_m_s), (_STANDING_M_S, _FLYING_M_S), (1.0, _FLYING_SHARE)
    )
    found_m = _Heights(on_grid_m, share, duration_s / steps, limits, floor_m).nearest_m()
    if np.abs(found_m - on_grid_m).max() <= _CHANGED_M:
        return height_m
    return np.maximum(np.interp(time_s, grid_s, found_m), floor_m)


class _Heights:
    """The convex problem on a grid of times ``step_s`` apart, mirrored behind its end.

    ``share`` (n,) is how much of the vertical acceleration may be used.
    """

    def __init__(
        self, height_m: Floats, share: Floats, step_s: float, limits: Limits, floor_m: float
    ) -> None:
        n = len(height_m)
        self._wanted = np.concatenate([height_m, height_m[::-1]])
        self._step_s = step_s
        up, down = limits.wp_speed_up_m_s, limits.wp_speed_down_m_s
        self._slowest = np.repeat([-down, -up], n)
        self._fastest = np.repeat([up, down], n)
        self._accel = limits.wp_accel_z_m_s2 * np.concatenate([share, share[::-1]])
        self._floor_m = floor_m
        square = (2.0 - 2.0 * np.cos(2.0 * np.pi * np.fft.rfftfreq(2 * n))) / step_s**2
        self._divisor = 1.0 + _FLOOR_WEIGHT + _RATE_WEIGHT * square + _ACCEL_WEIGHT * square**2

    def nearest_m(self) -> Floats:
        """The heights (n,) that keep the limits with the smallest squared differences."""
        height = self._wanted
        kept = self._bounded(self._measures(height))
        debt = [np.zeros_like(each) for each in kept]
        for round_ in range(_ROUNDS):
            before, height = height, self._solved([k - d for k, d in zip(kept, debt, strict=True)])
            measures = self._measures(height)
            mixed = [_RELAXATION * m + (1 - _RELAXATION) * k for m, k in zip(measures, kept, strict=True)]
            kept = self._bounded([m + d for m, d in zip(mixed, debt, strict=True)])
            debt = [d + m - k for d, m, k in zip(debt, mixed, kept, strict=True)]
            if round_ % _ROUNDS_A_CHECK == 0:
                broken = max(np.abs(m - k).max() for m, k in zip(measures, kept, strict=True))
                if broken < _TOLERANCE and np.abs(height - before).max() < _SETTLED_M:
                    break
        return height[: len(height) // 2]

    def _measures(self, height: Floats) -> list[Floats]:
        """What is limited: heights, rates and accelerations."""
        following, before = np.roll(height, -1), np.roll(height, 1)
        return [
            height,
            (following - height) / self._step_s,
            (following - 2.0 * height + before) / self._step_s**2,
        ]

    def _bounded(self, measures: list[Floats]) -> list[Floats]:
        height, rate, accel = measures
        return [
            np.maximum(height, self._floor_m),
            np.clip(rate, self._slowest, self._fastest),
            np.clip(accel, -self._accel, self._accel),
        ]

    def _solved(self, targets: list[Floats]) -> Floats:
        """Heights with the smallest squared differences from the wanted ones and from the targets."""
        height, rate, accel = targets
        pull = self._wanted + _FLOOR_WEIGHT * height
        pull = pull + _RATE_WEIGHT * (np.roll(rate, 1) - rate) / self._step_s
        curving = np.roll(accel, -1) - 2.0 * accel + np.roll(accel, 1)
        pull = pull + _ACCEL_WEIGHT * curving / self._step_s**2
        return np.fft.irfft(np.fft.rfft(pull) / self._divisor, len(pull))

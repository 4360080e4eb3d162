"""Flown against recorded: how far apart, in space and in time.

Ground metres in one local frame, shapes (n, 2). In space, the recorded fixes are matched to a path
going forwards only, so that a path that crosses itself cannot borrow; of all such matchings, the one
with the smallest sum of distances counts. In time, both clocks start together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.matching import match_in_order


@dataclass(frozen=True, slots=True)
class ErrorStatistics:
    """Mean, 95th percentile and largest of some distances, metres."""

    mean: float
    p95: float
    max: float


def error_statistics(distances_m: ArrayLike) -> ErrorStatistics | None:
    """Summary of distances; None when there are none."""
    distances = np.asarray(distances_m, float)
    if not distances.size:
        return None
    # np.percentile would import numpy.ma, a tenth of a short run's time.
    p95 = np.interp(0.95 * (distances.size - 1), np.arange(distances.size), np.sort(distances))
    return ErrorStatistics(float(distances.mean()), float(p95), float(distances.max()))


def path_errors_m(fixes_m: ArrayLike, path_m: ArrayLike) -> Floats:
    """Distances (n,) of fixes (n, 2) from a path (m, 2), matched forwards only; see ``match_in_order``."""
    return match_in_order(fixes_m, path_m).distance_m


def position_errors_m(
    recorded_s: ArrayLike, recorded_m: ArrayLike, flown_s: ArrayLike, flown_m: ArrayLike
) -> Floats:
    """Distances at equal times of recorded (n, 2) and flown (k, 2) positions, over what both have.

    Each clock counts from its own zero: the section's start, and the first waypoint's reaching.
    The flown position is interpolated at the times of the recorded fixes.
    """
    times, flown_times = np.asarray(recorded_s, float), np.asarray(flown_s, float)
    fixes, flown = np.asarray(recorded_m, float).reshape(-1, 2), np.asarray(flown_m, float).reshape(-1, 2)
    if not len(flown_times):
        return np.zeros(0)
    both = (times >= flown_times[0]) & (times <= flown_times[-1])
    there = [np.interp(times[both], flown_times, flown[:, axis]) for axis in (0, 1)]
    return np.asarray(np.hypot(fixes[both, 0] - there[0], fixes[both, 1] - there[1]))

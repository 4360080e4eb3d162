"""Path error and position error: how far a recording is from a path, and from a flight.

Ground metres in one local frame, positions (n, 2). For the path error (cross-track), fixes are matched
to the path going forwards only, so that no fix is matched to a later lap of a path that crosses
itself; of all such matchings, the one with the smallest sum of distances counts. The position error
compares positions at equal times.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.matching import match_in_order


@dataclass(frozen=True, slots=True)
class ErrorStatistics:
    """Mean, 95th percentile and maximum of errors, metres."""

    mean: float
    p95: float
    max: float


def error_statistics(errors_m: ArrayLike) -> ErrorStatistics | None:
    """The statistics of some errors; None when there are none."""
    errors = np.asarray(errors_m, float)
    if not errors.size:
        return None
    # np.percentile would import numpy.ma, a tenth of a short run's time.
    p95 = np.interp(0.95 * (errors.size - 1), np.arange(errors.size), np.sort(errors))
    return ErrorStatistics(float(errors.mean()), float(p95), float(errors.max()))


def path_errors_m(fixes_m: ArrayLike, path_m: ArrayLike) -> Floats:
    """Distances (n,) of fixes (n, 2) from a path (m, 2), matched forwards only; see ``match_in_order``."""
    return match_in_order(fixes_m, path_m).distance_m


def position_errors_m(
    recorded_s: ArrayLike, recorded_m: ArrayLike, flown_s: ArrayLike, flown_m: ArrayLike
) -> Floats:
    """Distances (m,) of recorded from flown positions at equal times, for the m fixes that lie in both.

    The flown position is interpolated at the times of the recorded fixes.

    Args:
        recorded_s: times of n fixes, counted from where the comparison begins (n,).
        recorded_m: their positions (n, 2).
        flown_s: times of k flown positions, counted likewise, rising (k,).
        flown_m: the flown positions (k, 2).
    """
    times, flown_times = np.asarray(recorded_s, float), np.asarray(flown_s, float)
    fixes, flown = np.asarray(recorded_m, float).reshape(-1, 2), np.asarray(flown_m, float).reshape(-1, 2)
    if not len(flown_times):
        return np.zeros(0)
    both = (times >= flown_times[0]) & (times <= flown_times[-1])
    at_fixes = [np.interp(times[both], flown_times, flown[:, axis]) for axis in (0, 1)]
    return np.asarray(np.hypot(fixes[both, 0] - at_fixes[0], fixes[both, 1] - at_fixes[1]))

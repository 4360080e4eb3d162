"""How a draft would be flown, and how far that is from the recording: the objective of the fit.

The objective, in metres, smaller is better:

    shares x path errors, flown and planned
    + time share x what the position errors cost on average, flown

"Flown" is what the model of ArduCopter predicts, "planned" the path on paper. A path error counts both
ways, half and half: from every fix to the path, matched in order, and from every part of the path
back to the recorded line, so that an overshoot costs what it looks like. It is the power mean of
those distances with exponent 4, so that nothing is left far off: one point at 2 m counts as much as
sixteen at 1 m. The planned part keeps the route true for vehicles that fly with other gains or in
wind. Where the recorded speed is not asked for, both path errors are one, such a mean of the two: where
waypoints abound, the plan would else be followed to the centimetre, and flown twice as badly.
``TIME_SHARE`` is the trade between space and time: four metres behind the recorded vehicle cost as much
as one metre beside the track, and a vehicle that is far off is held to the track all the more, see
``lateness``. Where the recorded speed is not asked for, only being late counts, and less. Where heights are
as recorded, a position error is one in space, and fixes are matched in space: the path error stays that over
the ground.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import lengths_m, speeds_m_s
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.lateness import (
    counted_offsets_m,
    lateness_cost_m,
    lateness_slope,
    position_offsets_m,
)
from flight_replay.planning.fit.offsets import Offsets, match_to_flight, match_to_plan
from flight_replay.planning.fit.reference import LocalTrack
from flight_replay.planning.fit.simulated_draft import SimulatedDraft

PATH_SHARES, TIMED_PATH_SHARES = (0.7, 1.3), (1.0, 0.3)
"""What path errors count, flown and planned, where the recorded speed is not asked for, and where it is kept:
there the planned path has to lead the vehicle, which swings out of curves.
"""
LATE_SHARE, TIME_SHARE = 0.15, 0.25
"""Where the recorded speed is not asked for, and where it is kept."""
_LEAST_SCALE_M = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """A draft as the model flies it, against the recording's n fixes.

    ``planned`` and ``flown`` are each the offsets of both ways: of the fixes, and of the path's own points.
    ``flown_s`` (n,) is when the vehicle flies by each fix, ``late_off_m`` (n, axes) the way from where it
    ought to be at the time of each, as far as that counts, see ``lateness``.
    ``timed`` says whether the recorded speed is to be kept.
    """

    flight: SimulatedDraft
    planned: tuple[Offsets, Offsets]
    flown: tuple[Offsets, Offsets]
    flown_s: Floats
    late_off_m: Floats
    timed: bool

    @property
    def draft(self) -> Draft:
        """What was flown."""
        return self.flight.draft

    @property
    def passed_s(self) -> Floats:
        """When each place was reached, counted from the first."""
        return self.flight.passed_s

    @property
    def late_m(self) -> Floats:
        """How far from where it ought to be it is at the time of each fix (n,), where that counts."""
        return lengths_m(self.late_off_m)

    @property
    def path_shares(self) -> tuple[float, float]:
        """What the path errors count, flown and planned."""
        return TIMED_PATH_SHARES if self.timed else PATH_SHARES

    @property
    def time_share(self) -> float:
        """What the mean position error counts."""
        return TIME_SHARE if self.timed else LATE_SHARE

    @property
    def path_errors_m(self) -> tuple[float, float]:
        """The path errors that count, flown and planned; at the vehicle's own speed that of both together."""
        flown, planned = path_error_m(self.flown), path_error_m(self.planned)
        if self.timed:
            return flown, planned
        both = _both_path_errors_m(flown, planned)
        return both, both

    @property
    def path_cost_m(self) -> float:
        """What the path errors add to the objective."""
        return float(np.dot(self.path_shares, self.path_errors_m))

    @property
    def objective_m(self) -> float:
        """The number that the fit makes small, see the module; infinite if the vehicle does not stay up."""
        if not self.flight.stays_up:
            return inf
        return self.path_cost_m + self.time_share * float(lateness_cost_m(self.late_m).mean())


def path_error_m(both_ways: tuple[Offsets, Offsets]) -> float:
    """Power mean with exponent 4 of distances, both ways alike."""
    return float(np.mean([(offsets.apart_m**4).mean() for offsets in both_ways]) ** 0.25)


def _both_path_errors_m(flown_m: float, planned_m: float) -> float:
    """The power mean of both, each counting by its share."""
    return float(np.average([flown_m**4, planned_m**4], weights=PATH_SHARES) ** 0.25)


def scales_of(evaluation: Evaluation) -> tuple[float, float]:
    """The path errors, flown and planned, about which what legs cost is linear; not too small."""
    flown, planned = evaluation.path_errors_m
    return max(flown, _LEAST_SCALE_M), max(planned, _LEAST_SCALE_M)


def leg_costs_m(evaluation: Evaluation, scales_m: tuple[float, float], *, whole: bool) -> Floats:
    """What the errors on the leg to each place (n,) add to the objective, linear about its path errors.

    Args:
        evaluation: a draft as it is flown.
        scales_m: the path errors, flown and planned.
        whole: whether being late counts, or the path errors only.
    """
    legs = len(evaluation.draft)
    cost = np.zeros(legs)
    kinds = zip((evaluation.flown, evaluation.planned), evaluation.path_shares, scales_m, strict=True)
    for both_ways, share, scale_m in kinds:
        for offsets in both_ways:
            total = np.bincount(offsets.leg, offsets.apart_m**4, minlength=legs)
            cost += share * total / (2 * len(offsets.leg) * 4 * scale_m**3)
    if whole:
        cost_m = lateness_cost_m(evaluation.late_m)
        by_leg_m = np.bincount(evaluation.planned[0].leg, cost_m, minlength=legs)
        cost += evaluation.time_share * by_leg_m / len(cost_m)
    return cost


def seconds_cost_m_s(evaluation: Evaluation, recording: LocalTrack) -> Floats:
    """What being a second later costs of the objective from the time of each fix (n,) on, if late counts."""
    flight = evaluation.flight
    speed_m_s = np.interp(
        recording.time_s, flight.time_s, speeds_m_s(flight.time_s, flight.place_m[:, : recording.axes])
    )
    late_m = evaluation.late_m
    late_m_s = np.where(late_m > 0, speed_m_s * lateness_slope(late_m), 0.0)
    return np.asarray(evaluation.time_share * np.cumsum(late_m_s[::-1])[::-1] / len(recording))


def objective_lower_bound_m(draft: Draft, recording: LocalTrack) -> float:
    """What the objective of a draft comes to at least, at the vehicle's own speed, by its plan alone."""
    planned_m = path_error_m(match_to_plan(draft, recording))
    return sum(PATH_SHARES) * _both_path_errors_m(0.0, planned_m)


def evaluate(flight: SimulatedDraft, recording: LocalTrack, *, timed: bool) -> Evaluation:
    """Compare a flight in the model with what it ought to follow.

    Args:
        flight: in the metres of the recording.
        recording: at least one fix.
        timed: whether being early counts.
    """
    off_m = position_offsets_m(flight, recording)
    matched = match_to_flight(flight, recording, lengths_m(off_m) if timed else None)
    late_off_m = counted_offsets_m(off_m, recording, matched.flown_s)
    if not timed:
        late_off_m = np.where((matched.flown_s > recording.time_s)[:, None], late_off_m, 0.0)
    return Evaluation(flight, matched.planned, matched.flown, matched.flown_s, late_off_m, timed)

"""What a fit gives: the mission, what it follows, and how it will look in the air."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.polyline import lengths_m
from flight_replay.logs.track import Track
from flight_replay.mission.items import Mission
from flight_replay.planning.fit.lateness import position_offsets_m
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.simulated_draft import SimulatedDraft
from flight_replay.planning.heights import Heights
from flight_replay.planning.stretches import worst_stretches
from flight_replay.writing.counted import counted

MIN_LAG_M = 5.0
"""Nearer behind or ahead than this is keeping to the recorded times."""
_CANNOT_KEEP_UP = "The vehicle cannot keep up everywhere: it is expected to be behind by"
_BEHIND = "It is expected to be behind the recording by"
_AHEAD = "It is expected to be ahead of the recording by"
_FEW_SHARE, _FEW_ERROR_M = 0.9, 1.0
"""With about as many waypoints as there may be, and farther beside the recording, there are too few."""


@dataclass(frozen=True, slots=True, eq=False)
class FitResult:
    """A fitted mission.

    ``flown`` is the part of the log that it follows, the clock running on from flight to flight,
    ``heights`` those of its fixes. ``flight`` is the predicted one, in the metres of ``flat_frame(flown)``;
    ``predicted_duration_s`` runs from reaching the first waypoint to the end. ``notes`` are sentences for a
    person, one of them where the vehicle ``cannot_keep_up`` with the recording; ``objective_m`` is what the
    fit made small, see ``objective``.
    """

    mission: Mission
    flown: Track
    heights: Heights
    flight: SimulatedDraft
    predicted_duration_s: float
    objective_m: float
    notes: tuple[str, ...]
    cannot_keep_up: bool = False


def few_waypoints_note(best: Evaluation, most: int) -> str:
    """A sentence where more than so many waypoints would follow the recording more closely, else nothing."""
    places, beside_m = len(best.draft), float(best.flown[0].apart_m.mean())
    if places < _FEW_SHARE * most or beside_m < _FEW_ERROR_M:
        return ""
    return (
        f"With {counted(places, 'waypoint')} the vehicle is expected to fly {beside_m:.1f} m "
        "beside the recording on average; more of them follow it more closely (--max-points)."
    )


def fit_notes(best: Evaluation, problem: FitProblem, most: int) -> tuple[tuple[str, ...], bool]:
    """Sentences on how a predicted flight is off the recording, and whether the vehicle cannot keep up.

    Args:
        best: the predicted flight.
        problem: what it was compared with.
        most: how many waypoints there may be: with too few it is not the vehicle that does not keep up.
    """
    few = few_waypoints_note(best, most)
    behind, ahead = _off_time(best, problem, 1), _off_time(best, problem, -1)
    late = f"{_BEHIND if few else _CANNOT_KEEP_UP} {behind}" if behind else ""
    early = f"{_AHEAD} {ahead}" if ahead else ""
    return tuple(filter(None, [few, late, early])), bool(behind and not few)


def _off_time(best: Evaluation, problem: FitProblem, sign: int) -> str:
    """Where the vehicle is farthest behind the recording (1) or ahead of it (-1), if that counts."""
    if not problem.timed:
        return ""
    recorded_s = problem.recording.time_s
    apart_m = lengths_m(position_offsets_m(best.flight, problem.recording))
    off_m = np.where(sign * (best.flown_s - recorded_s) > 0, apart_m, 0.0)
    off = off_m > MIN_LAG_M
    return f"up to {worst_stretches(off, off_m, recorded_s, 0)}." if off.any() else ""

"""What a fit gives: the mission, what it follows, and how it will look in the air."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Flags
from flight_replay.geometry.polyline import lengths_m
from flight_replay.logs.track import Track
from flight_replay.mission.items import Mission
from flight_replay.planning.fit.lateness import position_offsets_m
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.simulated_draft import SimulatedDraft
from flight_replay.planning.heights import Heights
from flight_replay.planning.stretches import worst_stretches

MIN_LAG_M = 5.0
"""Nearer behind or ahead than this is keeping to the recorded times."""
_BEHIND = "The vehicle cannot keep up everywhere: it is expected to be behind by"
_AHEAD = "It is expected to be ahead of the recording by"


@dataclass(frozen=True, slots=True, eq=False)
class FitResult:
    """A fitted mission.

    ``flown`` is the part of the log that it follows, the clock running on from flight to flight,
    ``heights`` those of its fixes. ``flight`` is the predicted one, in the metres of ``flat_frame(flown)``;
    ``predicted_duration_s`` runs from reaching the first waypoint to the end. ``notes`` are sentences for a
    person, one of them on where the vehicle ``is_behind`` the recording, if it is; ``objective_m`` is what
    the fit made small, see ``objective``.
    """

    mission: Mission
    flown: Track
    heights: Heights
    flight: SimulatedDraft
    predicted_duration_s: float
    objective_m: float
    notes: tuple[str, ...]
    is_behind: bool


def lag_notes(best: Evaluation, problem: FitProblem) -> tuple[str | None, str | None]:
    """Sentences on where the vehicle is farthest behind the recording, and ahead of it; None if nowhere.

    Args:
        best: the predicted flight.
        problem: what it was compared with.
    """
    if not problem.timed:
        return None, None
    recorded_s = problem.recording.time_s
    apart_m = lengths_m(position_offsets_m(best.flight, problem.recording))

    def note(said: str, is_off: Flags) -> str | None:
        off_m = np.where(is_off, apart_m, 0.0)
        off = off_m > MIN_LAG_M
        return f"{said} up to {worst_stretches(off, off_m, recorded_s, 0)}." if off.any() else None

    late_s = best.flown_s - recorded_s
    return note(_BEHIND, late_s > 0), note(_AHEAD, late_s < 0)

"""What a fit gives: the mission, what it follows, and how it will look in the air."""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.compare import Spread
from flight_replay.geodesy import Floats, LocalFrame
from flight_replay.mission import Mission
from flight_replay.track import Track


@dataclass(frozen=True, slots=True, eq=False)
class FitResult:
    """A fitted mission.

    ``flown`` is the part of the log that it follows, the clock running on from flight to flight.
    ``planned`` is its distance in space from the planned path, ``predicted_space`` and
    ``predicted_time`` those from the predicted flight; ``predicted_duration_s`` runs from reaching
    the first waypoint to the end. ``time_s`` (k,), from reaching the first waypoint, and ``place_m`` (k, 3),
    north, east of ``frame``'s origin and up, are the predicted flight. ``notes`` are sentences for
    a person; ``objective_m`` is what the fit made small, see ``forecast``.
    """

    mission: Mission
    flown: Track
    frame: LocalFrame
    planned: Spread
    predicted_space: Spread
    predicted_time: Spread
    predicted_duration_s: float
    objective_m: float
    time_s: Floats
    place_m: Floats
    notes: tuple[str, ...]

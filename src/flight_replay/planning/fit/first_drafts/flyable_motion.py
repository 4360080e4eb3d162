"""The recording as a vehicle could fly it: what waypoints are selected from where it cannot keep up.

A vehicle that is slower than the recorded one has to take shorter ways. Waypoints on the recorded path do
not let it, and which of them to move where is hard to see for a search that moves them a little at a time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.planning.fit.reference import DECIMALS, LocalTrack
from flight_replay.planning.smoothing import Knots, Samples, length_bound, nearest_motion

_KNOT_STEP_S = 0.4
_SMOOTHNESS_S6 = 1.0
"""As smooth as a curve through waypoints two seconds apart."""


def flyable_motion(recording: LocalTrack, most_m_s2: float) -> LocalTrack:
    """The same fixes, each where a smooth motion near the recording is at its time; the ends stay.

    Args:
        recording: at least two fixes.
        most_m_s2: the most horizontal acceleration of the motion, which begins and ends at rest.
    """
    knots = Knots.between(0.0, float(recording.time_s[-1]), _KNOT_STEP_S)
    samples = Samples(recording.time_s, recording.north_east_m, np.ones(len(recording)))
    try:
        found = nearest_motion(knots, samples, [length_bound(knots, 2, 2, most_m_s2)], _SMOOTHNESS_S6)
    except MissionError:  # It is only where a search begins.
        return recording
    places_m = knots.values(recording.time_s) @ found
    places_m[[0, -1]] = recording.north_east_m[[0, -1]]
    return replace(recording, north_east_m=places_m.round(DECIMALS))

"""How much farther ahead targets have to be taken, learned in flight from how late the vehicle is.

Leads are those of a firmware. What a link, a simulator's speed or an airframe adds shows in flight: a
vehicle that is always a little behind on its way, or ahead, is late by the same time everywhere. A slow
integral controller takes that time out; what changes from turn to turn it leaves alone.
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats

_LEARNING_S = 15.0
"""Of flight at the usual speed until two thirds are learned: much longer than a vehicle takes to react."""
_MEAN_S = 30.0
_MOST_S = 0.4
_SLOWEST_M2_S2 = 1.0
_LONGEST_STEP_S = 0.5


class LearnedLead:
    """The time that targets are taken ahead beside the leads of the firmware, ``lead_s``."""

    def __init__(self) -> None:
        self.lead_s = 0.0
        self._mean_m2_s2 = _SLOWEST_M2_S2
        self._time_s: float | None = None

    def observe(self, time_s: float, behind_m: Floats, velocity_m_s: Floats) -> None:
        """At the vehicle's time ``time_s`` it was ``behind_m`` (3,) from its target, and moved on (3,).

        The time that makes the squared distances small weighs places by the square of the speed there;
        those much faster than before count as the usual, until that is known.
        """
        step_s = 0.0 if self._time_s is None else time_s - self._time_s
        self._time_s = time_s
        if not 0.0 < step_s <= _LONGEST_STEP_S:
            return
        speed_m2_s2 = float(velocity_m_s @ velocity_m_s)
        self._mean_m2_s2 += (speed_m2_s2 - self._mean_m2_s2) * step_s / _MEAN_S
        usual_m2_s2 = max(self._mean_m2_s2, speed_m2_s2, _SLOWEST_M2_S2)
        late_s = float(behind_m @ velocity_m_s) / usual_m2_s2
        self.lead_s = float(np.clip(self.lead_s + late_s * step_s / _LEARNING_S, -_MOST_S, _MOST_S))

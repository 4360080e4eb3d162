"""How a target brakes, for a vehicle that gets no further one: it is to slow down on its way, in its turn.

A vehicle without targets goes on with the last one's acceleration, which stays as it is, while that of the
motion changes. Targets therefore have the acceleration that leads to where a motion that brakes gets to.
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.reference_motion import ReferenceMotion

_COMES_S = 0.7  # From a target to where it leads: until vehicles brake by themselves, and a little beyond.
_LEVEL = np.array([1.0, 1.0, 0.0])


def braking_way(reference: ReferenceMotion, recording_s: float, rate: float, braking_m_s2: float) -> Floats:
    """What a target's acceleration lacks of the motion's (3,), as a share of the braking: at most 1 long.

    It is shorter where the clock runs slower, because what brakes is no part of what the vehicle can speed
    up with.

    Args:
        reference: what is followed.
        recording_s: where on it the target is.
        rate: of the reference's clock.
        braking_m_s2: how hard targets brake.
    """
    if braking_m_s2 <= 0.0 or rate <= 0.0:
        return np.zeros(3)
    state = reference.state(recording_s)
    velocity_m_s = rate * state.velocity_m_s * _LEVEL
    # As hard as at most to rest by then, never backwards.
    slower_per_s = braking_m_s2 / max(float(np.linalg.norm(velocity_m_s)), braking_m_s2 * _COMES_S)
    comes_s = _COMES_S - slower_per_s * _COMES_S**2 / 2
    comes_m = reference.state(recording_s + rate * comes_s).position_m - state.position_m
    leads_m_s2 = 2 * (comes_m * _LEVEL - velocity_m_s * _COMES_S) / _COMES_S**2
    lacks = (rate**2 * state.acceleration_m_s2 * _LEVEL - leads_m_s2) / braking_m_s2
    return np.asarray(lacks * (rate / max(float(np.linalg.norm(lacks)), 1.0)))

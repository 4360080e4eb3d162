"""How fast the reference's clock may run for a vehicle whose drag leaves too little lean for its pace.

A vehicle that is asked for more than its lean gives flies off course, and its controllers wind up. A motion
flown slower takes less: its acceleration by the square of the clock's rate, its drag by about as much.
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.reference_motion import ReferenceMotion

_SHARE = 0.93  # Of the lean: about as much as references are planned with along the way.
_STEP_S, _AHEAD_S = 0.1, 4.0
_SLOWER_PER_S = 0.2  # The clock slows down a little faster than that.
_RATES = np.linspace(1.0, 0.3, 36)


class Pace:
    """The rates that a reference may be flown at; ``reference.thrust`` is known."""

    def __init__(self, reference: ReferenceMotion) -> None:
        thrust = reference.thrust
        assert thrust is not None, "without it there is nothing to keep to"
        times_s = np.arange(reference.begin_s, reference.end_s, _STEP_S)
        velocity_m_s = reference.velocities_m_s(times_s)[:, :2]
        speed_m_s = np.linalg.norm(velocity_m_s, axis=1, keepdims=True)
        self._begin_s, self._most_m_s2 = reference.begin_s, _SHARE * thrust.most_m_s2
        self._acceleration_m_s2 = reference.accelerations_m_s2(times_s)[:, :2]
        self._linear_m_s2 = thrust.drag_per_s * velocity_m_s
        self._square_m_s2 = thrust.drag_per_m * speed_m_s * velocity_m_s

    def rate(self, recording_s: float, drag: float) -> float:
        """The most that the clock may run at now, so that it need never slow down in a hurry.

        Args:
            recording_s: the reference's time.
            drag: how many times as much drag the vehicle has as the reference was planned with.
        """
        if drag <= 1.0:
            return 1.0
        begin = max(int((recording_s - self._begin_s) / _STEP_S), 0)
        near = slice(begin, begin + int(_AHEAD_S / _STEP_S))
        steady_m_s2 = self._acceleration_m_s2[near] + drag * self._square_m_s2[near]
        if not len(steady_m_s2):
            return 1.0
        rates = _RATES[:, None, None]
        needed_m_s2 = np.linalg.norm(rates**2 * steady_m_s2 + rates * drag * self._linear_m_s2[near], axis=2)
        enough = needed_m_s2 <= self._most_m_s2
        fastest = np.where(enough.any(axis=0), _RATES[enough.argmax(axis=0)], _RATES[-1])
        return min(1.0, float((fastest + _SLOWER_PER_S * _STEP_S * np.arange(len(fastest))).min()))

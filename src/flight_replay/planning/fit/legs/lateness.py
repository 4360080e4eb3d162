"""What it costs that a part of a draft takes longer: all after it is later, until there is time to spare.

Where the vehicle could fly faster than it does, it makes good what it has lost. Where it is late
already, a second gained is a second less late.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.objective import TIME_SHARE, Evaluation
from flight_replay.planning.fit.reference import LocalTrack

_NOTHING_S = 0.01
_LATEST_S, _TENTH_S = 25.6, 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Lateness:
    """By how much each place is left late (n,), the time to spare on each leg (n,), and what a second costs.

    ``second_m`` (n,) is what one second on the leg to each place adds to the objective.
    """

    late_s: Floats
    spare_s: Floats
    second_m: Floats

    @classmethod
    def of(cls, flown: Evaluation, recording: LocalTrack, wanted_s: Floats, least_s: Floats) -> Lateness:
        """The lateness of a draft as it is flown.

        Args:
            flown: the draft.
            recording: which it follows.
            wanted_s: when each place is to be left (n,).
            least_s: what each leg takes at least (n,).
        """
        places = len(flown.draft)
        leg = np.maximum.accumulate(flown.planned[0].leg)
        second_m = np.bincount(leg, recording.speed_m_s, minlength=places) / len(recording)
        duration_s = np.diff(flown.passed_s, prepend=0.0)
        return cls(flown.passed_s - wanted_s, np.maximum(duration_s - least_s, 0.0), TIME_SHARE * second_m)

    def cost_m(self, last: int, later_s: float) -> float:
        """What it adds to the objective that the place ``last`` is left so much later."""
        shift_s, _ = self._shifts(last, later_s)
        change = np.abs(self.late_s + shift_s) - np.abs(self.late_s)
        return float((change * self.second_m).sum())

    def most_later_s(self, last: int, most_m: float) -> float:
        """How much later the place ``last`` may be left, to 0.1 s, if that is to cost so much at most."""
        enough, too_much = 0.0, _LATEST_S
        while too_much - enough > _TENTH_S:
            middle = 0.5 * (enough + too_much)
            if self.cost_m(last, middle) <= most_m:
                enough = middle
            else:
                too_much = middle
        return too_much

    def later(self, last: int, later_s: float) -> Lateness:
        """The lateness when the place ``last`` is left so much later."""
        shift_s, spare_s = self._shifts(last, later_s)
        return replace(self, late_s=self.late_s + shift_s, spare_s=spare_s)

    def _shifts(self, last: int, later_s: float) -> tuple[Floats, Floats]:
        """How much later the places after ``last`` are left, and the time to spare that remains."""
        shift_s, spare_s = np.zeros(len(self.late_s)), self.spare_s.copy()
        for place in range(last + 1, len(shift_s)):
            if abs(later_s) < _NOTHING_S:
                break
            if later_s > 0:
                made_good = min(later_s, float(spare_s[place]))
                later_s -= made_good
                spare_s[place] -= made_good
            else:
                # Who is not late need not hurry: what is gained beyond that is spent on flying slower.
                later_s = max(later_s, -max(float(self.late_s[place]), 0.0))
            shift_s[place] = later_s
        return shift_s, spare_s

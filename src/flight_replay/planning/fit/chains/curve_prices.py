"""What it costs on paper to go on from one draft as another: the legs around have other curves then."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate, chain

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.hermite_curve import weights_of_steps
from flight_replay.geometry.polyline import lengths_along_m
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.reference import LocalTrack
from flight_replay.planning.fit.scalar.knot_cost import CandidateKnots, KnotCost

_STEPS_A_LEG = 12


class CurvePrices:
    """The planned legs of some drafts, n together, one draft's after another's, beside the recording."""

    def __init__(
        self, recording: LocalTrack, drafts: Sequence[Draft], passing_s: Floats, path_share: float
    ) -> None:
        """With when the recording was where each leg ends (n,).

        ``path_share`` is what the objective changes by the mean of fourth powers of distances.
        """
        lengths = [len(draft) for draft in drafts]
        ends = list(accumulate(lengths))
        # Of each leg, the first of its draft and the one after its last.
        self._begin = [end - count for end, count in zip(ends, lengths, strict=True) for _ in range(count)]
        self._end = [end for end, count in zip(ends, lengths, strict=True) for _ in range(count)]
        fixes_m = recording.places_m
        fix = np.searchsorted(recording.time_s, passing_s).clip(0, len(recording) - 1).tolist()
        stops = list(chain.from_iterable([True, *draft.halts[1:].tolist()] for draft in drafts))
        straight = list(chain.from_iterable((~draft.spline).tolist() for draft in drafts))
        places_m = np.concatenate([draft.places_m[:, : recording.axes] for draft in drafts])
        columns = (fixes_m.tolist(), recording.time_s.tolist(), lengths_along_m(fixes_m).tolist())
        knots = CandidateKnots(places_m.tolist(), fix, fix, stops, straight)
        self._cost = KnotCost(knots, columns, weights_of_steps(_STEPS_A_LEG), path_share, 0.0)
        self._usual = [self._usual_m(leg) for leg in range(len(places_m))]

    def prices_m(self, here: Indices, there: Indices) -> Floats:
        """What three legs cost more (k,) where what follows legs ``there`` (k,) follows ``here`` (k,)."""
        return np.array([self._price_m(*link) for link in zip(here.tolist(), there.tolist(), strict=True)])

    def _usual_m(self, leg: int) -> float:
        """What the leg to a place costs in its own draft; nothing for the first."""
        begin, last = self._begin[leg], self._end[leg] - 1
        if leg == begin:
            return 0.0
        return self._cost.leg_m(max(leg - 2, begin), leg - 1, leg, min(leg + 1, last))

    def _price_m(self, here: int, there: int) -> float:
        begin, last = self._begin[here], self._end[there] - 1
        if there == last:
            return 0.0
        leg_m, after = self._cost.leg_m, there + 1
        more_m = leg_m(max(here - 1, begin), here, after, min(there + 2, last)) - self._usual[after]
        if here > begin:
            more_m += leg_m(max(here - 2, begin), here - 1, here, after) - self._usual[here]
        if after < last:
            more_m += leg_m(here, after, after + 1, min(after + 2, last)) - self._usual[after + 1]
        return max(0.0, more_m)

"""Delays that derivatives did not foretell, learned from steps that failed.

What its curves, its length and its speed allow decides together how long a leg takes: changes of two places
may each make it no longer, and both together do. A vehicle at its limits does not make up for that, and
is late for all that follows. So what a step was late by is laid to the changes around the legs on which
that came, and the next step by the same derivatives reckons with it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.planning.fit.lateness import velocities_at_m_s
from flight_replay.planning.fit.legs.flight_derivatives import FlightDerivatives
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.reference import LocalTrack
from flight_replay.planning.fit.steps.linear_model import Sides

_LEAST_S = 0.01
_LEAST_SIZE = 0.01
"""Changes that come to less of the usual together are not to blame: what is told from so little is noise."""
_BEFORE, _AFTER = 2, 1
"""A leg is shaped by its ends, and by one place before and one after them."""


@dataclass(frozen=True, slots=True, eq=False)
class Delays:
    """How much later n places are left for each of p changes, to whichever side: s, by their size (n, p)."""

    by_change: Floats

    @classmethod
    def none(cls, places: int, changes: int) -> Delays:
        """Before any step."""
        return cls(np.zeros((places, changes)))

    @property
    def are_known(self) -> bool:
        """Whether there are any."""
        return bool(self.by_change.any())

    def learned(self, changes: Floats, usual: Floats, places: Indices, late_s: Floats) -> Delays:
        """After a step.

        Args:
            changes: those of the step (p,), 0 for those that are not to blame.
            usual: how large each usually is (p,).
            places: of which place each is (p,).
            late_s: how much later than foretold each place was left (n,).
        """
        by_change, by_leg_s, shares = self.by_change.copy(), _by_leg_s(late_s), np.abs(changes) / usual
        for leg in np.flatnonzero(by_leg_s.max(axis=0) > _LEAST_S).tolist():
            around = (changes != 0) & (places >= leg - _BEFORE) & (places <= leg + _AFTER)
            size = shares[around].sum()
            if size > _LEAST_SIZE:
                by_size = around / (usual * size)
                by_change += by_leg_s[:, leg, None] * by_size
        return Delays(by_change)

    def added_to(self, sides: Sides, evaluation: Evaluation, recording: LocalTrack) -> Sides:
        """Derivatives to both sides that reckon with them.

        Args:
            sides: the derivatives as they were flown.
            evaluation: a draft as it is flown.
            recording: what its fixes are compared with.
        """
        if not self.are_known:
            return sides
        later_s = _at(self.by_change, evaluation.passed_s, recording.time_s)
        flight = evaluation.flight
        velocity_m_s = velocities_at_m_s(flight.time_s, flight.place_m[:, :2], recording.time_s)
        back_m = velocity_m_s[:, :, None] * later_s[:, None, :]
        other = sides.one if sides.other is None else sides.other
        return Sides(self._later(sides.one, back_m, 1.0), self._later(other, back_m, -1.0))

    def _later(self, derivatives: FlightDerivatives, back_m: Floats, side: float) -> FlightDerivatives:
        """Derivatives by changes to a side: the vehicle is so much farther back at the fixes (n, 2, p)."""
        at_fixes = derivatives.at_fixes - side * back_m.reshape(len(derivatives.at_fixes), -1)
        passed_s = derivatives.passed_s + side * self.by_change
        return replace(derivatives, at_fixes=at_fixes, passed_s=passed_s)


def _by_leg_s(late_s: Floats) -> Floats:
    """How much of each place's lateness (n,) arose on which leg (n, n).

    Time made up reduces all earlier shares alike.
    """
    late_s, by_leg_s = np.maximum(late_s, 0.0), np.zeros((len(late_s), len(late_s)))
    for place in range(1, len(late_s)):
        before_s, now_s = late_s[place - 1 : place + 1]
        by_leg_s[place] = by_leg_s[place - 1] * (min(now_s / before_s, 1.0) if before_s > 0 else 0.0)
        by_leg_s[place, place] = max(now_s - before_s, 0.0)
    return by_leg_s


def _at(columns: Floats, passed_s: Floats, time_s: Floats) -> Floats:
    """What columns (n, p) at the times (n,) are in between (m, p)."""
    at = np.interp(time_s, passed_s, np.arange(len(passed_s), dtype=float))
    begin = np.minimum(at.astype(np.intp), len(passed_s) - 2)
    part = (at - begin)[:, None]
    return np.asarray((1 - part) * columns[begin] + part * columns[begin + 1])

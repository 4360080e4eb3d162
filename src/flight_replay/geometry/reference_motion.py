"""The reference: the smooth motion that a vehicle follows in step with a recording."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame

if TYPE_CHECKING:
    from scipy.interpolate import BSpline


@dataclass(frozen=True, slots=True)
class MotionState:
    """Position, velocity and acceleration at one time: metres and seconds, north, east, up of the frame."""

    position_m: Floats
    velocity_m_s: Floats
    acceleration_m_s2: Floats

    def displaced(self, by: MotionState, share: float) -> MotionState:
        """The state with a share of another one added."""
        return MotionState(
            self.position_m + share * by.position_m,
            self.velocity_m_s + share * by.velocity_m_s,
            self.acceleration_m_s2 + share * by.acceleration_m_s2,
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class SmoothMotion:
    """A smooth motion, or displacement of one, over the recording's time, at rest before and after.

    ``position`` gives metres (3,), north, east, up, from ``begin_s`` to ``end_s``.
    """

    begin_s: float
    end_s: float
    position: BSpline

    def state(self, time_s: float) -> MotionState:
        """Position, velocity and acceleration at a time; at rest beyond both ends."""
        inside_s = min(max(time_s, self.begin_s), self.end_s)
        rest = inside_s != time_s
        return MotionState(
            self.position(inside_s),
            np.zeros(3) if rest else self._velocity(inside_s),
            np.zeros(3) if rest else self._acceleration(inside_s),
        )

    def times_s(self, step_s: float) -> Floats:
        """Times from begin to end, at most ``step_s`` apart."""
        return np.linspace(
            self.begin_s, self.end_s, max(int(np.ceil((self.end_s - self.begin_s) / step_s)), 1) + 1
        )

    def positions_m(self, times_s: Floats) -> Floats:
        """Positions (n, 3) at times (n,)."""
        return np.asarray(self.position(np.clip(times_s, self.begin_s, self.end_s)))

    def velocities_m_s(self, times_s: Floats) -> Floats:
        """Velocities (n, 3) at times (n,) between begin and end."""
        return np.asarray(self._velocity(times_s))

    def accelerations_m_s2(self, times_s: Floats) -> Floats:
        """Accelerations (n, 3) at times (n,) between begin and end."""
        return np.asarray(self._acceleration(times_s))

    @cached_property
    def _velocity(self) -> BSpline:
        return self.position.derivative(1)

    @cached_property
    def _acceleration(self) -> BSpline:
        return self.position.derivative(2)


@dataclass(frozen=True, slots=True)
class Thrust:
    """Level thrust per mass: the most that a vehicle's lean gives, and what the drag of its air takes of it.

    Drag is ``drag_per_s`` times the speed, and ``drag_per_m`` times its square.
    """

    most_m_s2: float
    drag_per_s: float
    drag_per_m: float


@dataclass(frozen=True, eq=False, kw_only=True)
class ReferenceMotion(SmoothMotion):
    """The motion that is followed: the recording's first fix is at 0 s, ``begin_s`` before that a run-up.

    ``position`` is in ``frame`` and above home; ``heading`` gives degrees (1,), clockwise from north and
    not wrapped, or is None if the vehicle turns as it wants. ``drag_lag`` is how far a vehicle would be
    beside its targets for the drag of SITL's quadcopter, if nothing made up for that, ``acceleration_lag``
    for what the firmware does not feed forward; None if unknown, or nothing. ``thrust`` is that of the
    vehicle with the same drag, None if unknown.
    """

    frame: FlatFrame
    heading: BSpline | None = None
    drag_lag: SmoothMotion | None = None
    acceleration_lag: SmoothMotion | None = None
    thrust: Thrust | None = None

    def heading_deg(self, time_s: float) -> tuple[float, float] | None:
        """Heading, 0 to 360 degrees, and its rate, degrees/s, if the reference has one."""
        if self.heading is None or self._heading_rate is None:
            return None
        inside_s = min(max(time_s, self.begin_s), self.end_s)
        rate = 0.0 if inside_s != time_s else float(self._heading_rate(inside_s)[0])
        return float(self.heading(inside_s)[0]) % 360.0, rate

    def headings_deg(self, times_s: Floats) -> tuple[Floats, Floats] | None:
        """Headings (n,), not wrapped, and their rates (n,), if the reference has them."""
        if self.heading is None or self._heading_rate is None:
            return None
        return np.asarray(self.heading(times_s))[:, 0], np.asarray(self._heading_rate(times_s))[:, 0]

    @cached_property
    def _heading_rate(self) -> BSpline | None:
        return None if self.heading is None else self.heading.derivative(1)


def motion_through(times_s: Floats, places_m: Floats) -> SmoothMotion:
    """The smooth motion that is at places (n, 3) at times (n,), at least four."""
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(times_s, places_m, k=3)
    return SmoothMotion(begin_s=float(times_s[0]), end_s=float(times_s[-1]), position=spline)

"""Follows a reference in step: what target to send when, and when the reference has to wait.

The reference's clock runs with the vehicle's. Where the vehicle falls behind, or the stream of targets
broke off, the clock goes back to where the vehicle is on the way, and the target moves from the vehicle
to the reference at walking speed: whatever happened, the vehicle is never sent off in a rush.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.reference_motion import MotionState, ReferenceMotion, SmoothMotion
from flight_replay.supervisor.learned_share import LearnedShare
from flight_replay.supervisor.motion.braking_targets import braking_way
from flight_replay.supervisor.motion.pace import Pace

TARGET_S = 0.1
"""Vehicle time between targets: ten a second follow as closely as fifty."""
OFF_COURSE = 3.0
"""So many times the error that the reference waits for ends the flight."""
_CLOCK_CHANGE_PER_S = 0.3  # A clock that starts or stops faster throws the vehicle off by itself.
_SPEED_UP_M_S2, _SLOW_DOWN_M_S2 = 0.6, 2.5  # Drag helps to slow down.
_REJOIN_M_S, _REJOIN_M_S2 = 2.0, 1.0
_SEARCH_STEP_S, _SEARCH_AHEAD_S = 0.05, 0.5
_STOPPING_S = 1.0  # A metre per second in another direction counts as much as a metre.
_CAUGHT_UP, _LOST = 0.5, 2.0
"""The reference waits until the error is half of what it may be, and begins anew at twice that."""
_REMEMBERED_S = 3.0
LONGEST_GAP_S = 0.5
"""Vehicles that had no target for so long are braking."""
_SETTLING_S, _SETTLING_RATE = 4.0, 0.6
"""After rejoining: a vehicle that has just braked is off its velocity and acceleration, too. In a slower turn
its lean suffices to make up for that; at full rate it flies off course by metres seconds later."""
_LEADS_S, _SLOWEST_M2_S2 = (-0.4, 0.4), 1.0
_DRAG_SHARES, _SMALLEST_LAG_M2 = (-0.5, 2.0), 0.02
_NOT_DRAG = 0.3
"""So much of a learned share of the drag's lag may be that of leads that do not fit everywhere."""


@dataclass(frozen=True, slots=True)
class Tuning:
    """What targets need for a firmware's controllers to follow them; the defaults: ArduCopter 4.1 and later.

    Of position, velocity, acceleration and heading: how far ahead of the vehicle's time they are taken.
    """

    position_s: float = 0.05
    velocity_s: float = 0.15
    acceleration_s: float = 0.05
    heading_s: float = 0.07
    feed_forward: float = 1.0
    """The share of a motion's acceleration that the controllers feed forward; below 1 they take it from
    how the velocity that they want changes."""
    delay_s: float = 0.0
    """From an acceleration that they ask for to that of the vehicle, where the leads leave it."""
    drag_share: float = 0.3
    """The share of ``ReferenceMotion.drag_lag`` that the leads leave for SITL's quadcopter."""
    drag_per_s: float | None = None
    """Drag of that quadcopter, if linear in speed; None for that of ArduCopter 4's SITL."""
    braking_m_s2: float = 2.0
    """How hard a target brakes until the next one comes: a vehicle that gets none slows down at once."""
    braking_ahead_m: float = 1.5
    """How far ahead it is on its way: what pulls the vehicle there makes up for the braking until then."""
    braking_slower_m_s: float = 0.5
    """How much slower it is, for which a part of that pull makes up, too: the vehicle slows down sooner."""


DEFAULT_TUNING = Tuning()


@dataclass(frozen=True, slots=True)
class MotionTarget:
    """Where to be and how to move: metres north, east, up in the reference's frame; heading in degrees."""

    position_m: Floats
    velocity_m_s: Floats
    acceleration_m_s2: Floats
    heading_deg: float | None
    heading_rate_deg_s: float


@dataclass(frozen=True, slots=True)
class Learned:
    """What flying teaches of where targets have to be.

    ``lead_s`` is how much earlier they are taken than the firmware's leads say, ``drag`` the share of
    ``ReferenceMotion.drag_lag`` that displaces them, ``displacement`` what earlier passes taught beside that.
    """

    lead_s: LearnedShare
    drag: LearnedShare
    displacement: SmoothMotion | None = None

    @staticmethod
    def nothing(tuning: Tuning = DEFAULT_TUNING) -> Learned:
        """Nothing learned yet: no lead, and the tuning's own share of the drag's lag."""
        return Learned(
            LearnedShare(0.0, _LEADS_S, _SLOWEST_M2_S2),
            LearnedShare(tuning.drag_share, _DRAG_SHARES, _SMALLEST_LAG_M2),
        )


class Follower:
    """The reference's clock beside the vehicle's, and the targets that follow from both."""

    def __init__(
        self,
        reference: ReferenceMotion,
        max_error_m: float,
        tuning: Tuning = DEFAULT_TUNING,
        learned: Learned | None = None,
    ) -> None:
        """Begin.

        Args:
            reference: what to follow.
            max_error_m: the reference waits for a vehicle that is farther away from its target.
            tuning: that of the firmware that flies.
            learned: what was learned before; it goes on being learned.
        """
        self.reference, self.max_error_m, self.tuning = reference, max_error_m, tuning
        self.recording_s = reference.begin_s
        """The recording's time that the vehicle is to be at now."""
        self.rate = 1.0
        """How fast that time runs: 0 while the reference waits."""
        self._change = 0.0
        self._offset_m = np.zeros(3)
        self._rejoin_m_s = 0.0
        self._settling_s = 0.0
        self._behind = False
        self.learned = learned or Learned.nothing(tuning)
        self._pace = None if reference.thrust is None else Pace(reference)
        self._time_s: float | None = None
        self._past: deque[tuple[float, float, Floats]] = deque()
        self.clock: list[tuple[float, float]] = []
        """Vehicle time and recording's time of each target."""
        self.misses: list[tuple[float, Floats]] = []
        """The recording's time, and where the vehicle was to be from where it was (3,), while in step."""
        self.error_m = 0.0
        """How far the vehicle was from its target when it was last looked at."""
        self.apart_m = 0.0
        """How far it was from the reference itself, wherever its targets were."""
        self.higher_m = 0.0
        """How far above the reference; negative if below."""

    @property
    def offset_m(self) -> float:
        """How far targets are from the reference, on the way back to it."""
        return float(np.linalg.norm(self._offset_m))

    @property
    def learned_lead_s(self) -> float:
        """How much earlier targets are taken than the firmware's leads say, as learned in this flight."""
        return self.learned.lead_s.value

    @property
    def waiting(self) -> bool:
        """Whether the reference waits for the vehicle."""
        return self.rate < 1.0

    def target(self, time_s: float) -> MotionTarget:
        """The target for the vehicle's time ``time_s``, which is later than that of the target before."""
        step_s = 0.0 if self._time_s is None else max(time_s - self._time_s, 0.0)
        self._time_s = time_s
        self._advance(step_s)
        target = self._moved(self.recording_s)
        self._past.append((time_s, self.recording_s, self._position_m(self.recording_s)))
        while time_s - self._past[0][0] > _REMEMBERED_S:
            self._past.popleft()
        self.clock.append((time_s, self.recording_s))
        return target

    def recording_at_s(self, time_s: float) -> float:
        """The recording's time at the vehicle's time ``time_s``, which is a little before the last target.

        Where that target was late, it is a little after it: the recording's time ran on.
        """
        if not self._past:
            return self.recording_s
        times_s, recordings_s = zip(*[each[:2] for each in self._past], strict=True)
        late_s = max(time_s - times_s[-1], 0.0)
        return float(np.interp(time_s, times_s, recordings_s) + self.rate * late_s)

    @property
    def begun(self) -> bool:
        """Whether there was a target."""
        return self._time_s is not None

    def gap_s(self, time_s: float) -> float:
        """How long there was no target, at the vehicle's time ``time_s``; negative where that went back."""
        return 0.0 if self._time_s is None else time_s - self._time_s

    def observe(self, time_s: float, position_m: Floats, velocity_m_s: Floats) -> None:
        """Where the vehicle was at its time ``time_s``; it rejoins the reference if it is too far off."""
        wanted_m = self._wanted_m(time_s)
        if wanted_m is None:
            return
        self.error_m = float(np.linalg.norm(position_m - wanted_m))
        apart_m = position_m - wanted_m + self._offset_m
        self.apart_m, self.higher_m = float(np.linalg.norm(apart_m)), float(apart_m[2])
        self._behind = self.error_m > self.max_error_m * (_CAUGHT_UP if self._behind else 1.0)
        if self.rate == 1.0 and self.offset_m == 0.0:
            self._learn(time_s, wanted_m - position_m, velocity_m_s)
        if self.error_m > _LOST * self.max_error_m:
            self.rejoin(position_m, velocity_m_s, back_s=_REMEMBERED_S, ahead_s=_SEARCH_AHEAD_S)

    def _learn(self, time_s: float, behind_m: Floats, velocity_m_s: Floats) -> None:
        recording_s, lag = self.recording_at_s(time_s), self.reference.drag_lag
        self.misses.append((recording_s, behind_m))
        self.learned.lead_s.observe(time_s, behind_m, velocity_m_s)
        if lag is not None:
            self.learned.drag.observe(time_s, behind_m, lag.state(recording_s).position_m)

    def resume(self, time_s: float, position_m: Floats, velocity_m_s: Floats) -> None:
        """Go on after a gap, with a target for ``time_s``, from where the vehicle is by then."""
        gap_s = self.gap_s(time_s)
        self._time_s = time_s
        self.rejoin(position_m, velocity_m_s, back_s=0.0, ahead_s=gap_s + _SEARCH_AHEAD_S)

    def rejoin(self, position_m: Floats, velocity_m_s: Floats, *, back_s: float, ahead_s: float) -> None:
        """Go on from where the vehicle is: the clock where its way is nearest to how it moves, at its pace.

        Then the clock runs slowly for some seconds, until the vehicle has settled.

        Args:
            position_m: of the vehicle (3,).
            velocity_m_s: of the vehicle (3,).
            back_s: how far behind the last target the vehicle may be.
            ahead_s: how far ahead of it the vehicle may have come.
        """
        reference = self.reference
        begin_s = max(self.recording_s - back_s, reference.begin_s)
        times_s = np.arange(begin_s, min(self.recording_s + ahead_s, reference.end_s) + 1e-9, _SEARCH_STEP_S)
        apart_m = reference.positions_m(times_s) - position_m
        paths_m_s = reference.velocities_m_s(times_s)
        pace = paths_m_s @ velocity_m_s / np.maximum((paths_m_s**2).sum(axis=1), 1e-3)
        pace = np.clip(pace, 0.0, 1.0)
        aside_m_s = velocity_m_s - pace[:, None] * paths_m_s
        best = int(np.argmin((apart_m**2).sum(axis=1) + (_STOPPING_S * aside_m_s**2).sum(axis=1)))
        self.recording_s, self.rate, self._change = float(times_s[best]), float(pace[best]), 0.0
        self._offset_m, self._rejoin_m_s = -apart_m[best], 0.0
        self.apart_m, self.higher_m = self.offset_m, float(self._offset_m[2])
        self._settling_s = _SETTLING_S
        self._behind = False
        self._past.clear()

    def _advance(self, step_s: float) -> None:
        wanted = self._wanted_rate()
        self._settling_s = max(self._settling_s - step_s, 0.0)
        speed_m_s = max(float(np.linalg.norm(self._at(self.recording_s).velocity_m_s)), 1e-3)
        faster = min(_CLOCK_CHANGE_PER_S, _SPEED_UP_M_S2 / speed_m_s) * step_s
        slower = min(_CLOCK_CHANGE_PER_S, _SLOW_DOWN_M_S2 / speed_m_s) * step_s
        change = min(max(wanted - self.rate, -slower), faster)
        self._change = change / step_s if step_s > 0 else 0.0
        self.recording_s += (self.rate + change / 2) * step_s
        self.rate += change
        self._approach(step_s)

    def _wanted_rate(self) -> float:
        """How fast the reference's clock is to run, once it has changed gently."""
        if self._behind or self.offset_m > self.max_error_m:
            return 0.0
        most = _SETTLING_RATE if self._settling_s > 0.0 else 1.0
        return most if self._pace is None else min(most, self._pace.rate(self.recording_s, self._drag))

    @property
    def _drag(self) -> float:
        """How many times as much drag the vehicle has as was planned with, as far as that is certain."""
        return 1.0 + max(self.learned.drag.value - self.tuning.drag_share - _NOT_DRAG, 0.0)

    def _approach(self, step_s: float) -> None:
        """Move the offset towards zero, slower near the end."""
        apart_m = self.offset_m
        allowed = min(_REJOIN_M_S, float(np.sqrt(2 * _REJOIN_M_S2 * apart_m)) / 2)
        self._rejoin_m_s = min(self._rejoin_m_s + _REJOIN_M_S2 * step_s, allowed)
        if apart_m <= self._rejoin_m_s * step_s or apart_m < 1e-3:
            self._offset_m, self._rejoin_m_s = np.zeros(3), 0.0
        else:
            self._offset_m = self._offset_m * (1.0 - self._rejoin_m_s * step_s / apart_m)

    def _moved(self, recording_s: float) -> MotionTarget:
        """The target at the recording's time, with each quantity ahead by its lead."""
        tuning, rate, reference, at = self.tuning, self.rate, self.reference, self._corrected
        heading = reference.heading_deg(recording_s + rate * tuning.heading_s)
        recording_s += rate * self.learned_lead_s
        velocity = rate * at(recording_s + rate * tuning.velocity_s).velocity_m_s
        ahead = at(recording_s + rate * tuning.acceleration_s)
        acceleration = rate * rate * ahead.acceleration_m_s2 + self._change * ahead.velocity_m_s
        apart_m = self.offset_m
        if apart_m > 0:
            velocity = velocity - self._offset_m * (self._rejoin_m_s / apart_m)
        way = braking_way(reference, recording_s, rate, tuning.braking_m_s2)
        return MotionTarget(
            at(recording_s + rate * tuning.position_s).position_m
            + self._offset_m
            + tuning.braking_ahead_m * way,
            velocity + (tuning.braking_m_s2 * TARGET_S / 2 - tuning.braking_slower_m_s) * way,
            acceleration - tuning.braking_m_s2 * way,
            None if heading is None else heading[0],
            0.0 if heading is None else rate * heading[1],
        )

    def _at(self, recording_s: float) -> MotionState:
        return self.reference.state(recording_s)

    def _corrected(self, recording_s: float) -> MotionState:
        """Where targets have to be for the vehicle to be on the reference.

        Corrections shrink with the clock's rate; at rest there are none.
        """
        learned, reference = self.learned, self.reference
        state = self._at(recording_s)
        for lag, share in (
            (reference.drag_lag, learned.drag.value),
            (reference.acceleration_lag, 1.0),
            (learned.displacement, 1.0),
        ):
            if lag is not None:
                state = state.displaced(lag.state(recording_s), self.rate * share)
        return state

    def _position_m(self, recording_s: float) -> Floats:
        return self._at(recording_s).position_m + self._offset_m

    def _wanted_m(self, time_s: float) -> Floats | None:
        """Where the vehicle was to be at its time ``time_s``; None before the first target."""
        past = self._past
        after = min(bisect_left([at_s for at_s, _, _ in past], time_s), len(past) - 1)
        if after < 1:
            return None
        (begin_s, _, begin_m), (end_s, _, end_m) = past[after - 1], past[after]
        return np.asarray(begin_m + (end_m - begin_m) * (time_s - begin_s) / (end_s - begin_s))

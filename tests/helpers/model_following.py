"""A reference followed by the flight model alone, as ``follow_phases`` has a vehicle follow it."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.planning.drag import Drag
from flight_replay.planning.following.reference_planner import RecordedMotion, ReferenceBounds, plan_reference
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.flight.guided import GuidedTarget
from flight_replay.supervisor.follower import LONGEST_GAP_S, TARGET_S, Follower
from flight_replay.vehicle.following import TARGET_TIMEOUT_S


def figures_of_eight(drag: Drag, lap_s: float, laps: int) -> ReferenceMotion:
    """A reference that takes almost all the lean that a vehicle with this drag has."""
    time_s = np.arange(0.0, laps * lap_s, 0.2)
    phase = 2 * np.pi * time_s / lap_s
    position_m = np.column_stack([18 * np.sin(phase), 9 * np.sin(2 * phase), np.full(len(phase), 30.0)])
    recorded = RecordedMotion(FlatFrame(47.0, 8.0), time_s, position_m, np.full(len(phase), np.nan))
    return plan_reference(recorded, ReferenceBounds.of(Limits()), drag, headings=False, floor_m=5.0)


class ModelFlight:
    """The flight model and its follower, step by step."""

    def __init__(self, follower: Follower, home_amsl_m: float = 0.0) -> None:
        self.follower, self._begin_s = follower, follower.reference.begin_s
        start_m = follower.reference.state(self._begin_s).position_m
        limits = Limits(guided_timeout_s=TARGET_TIMEOUT_S)
        self._copter = Copter(limits, position_m=_vector(start_m), home_amsl_m=home_amsl_m)
        self._next_s = self._begin_s

    @property
    def now_s(self) -> float:
        """The vehicle's clock, which begins with the reference's."""
        return self._begin_s + self._copter.time_s

    @property
    def position_m(self) -> Floats:
        """Where the vehicle is (3,)."""
        return np.array(self._copter.motion[1:4])

    def step(self, *, stopped: bool = False) -> None:
        """One step of the model; a target is sent if it is time for it and the program is not stopped."""
        if self.now_s >= self._next_s - 1e-9 and not stopped:
            self._next_s = self.now_s + TARGET_S
            self._send(self.now_s)
        self._copter.step()

    def _send(self, now_s: float) -> None:
        follower, velocity_m_s = self.follower, np.array(self._copter.motion[4:7])
        if follower.gap_s(now_s) > LONGEST_GAP_S:
            follower.resume(now_s, self.position_m, velocity_m_s)
        else:
            follower.observe(now_s, self.position_m, velocity_m_s)
        target = follower.target(now_s)
        place, velocity, acceleration = target.position_m, target.velocity_m_s, target.acceleration_m_s2
        self._copter.follow(GuidedTarget(_vector(place), _vector(velocity), _vector(acceleration), 0.0, 0.0))


def _vector(values: Floats) -> Vector:
    return float(values[0]), float(values[1]), float(values[2])

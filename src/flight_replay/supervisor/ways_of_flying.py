"""The two ways to fly a recording again: as a mission in AUTO, or followed in GUIDED.

``fly`` knows only what both have in common; take-off before and RTL after them are the same.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from flight_replay.events import PassFlown, Phase, PhaseStarted
from flight_replay.geometry.arrays import Floats
from flight_replay.supervisor.flight_plan import FollowPlan, Plan
from flight_replay.supervisor.follow_phases import approach, follow
from flight_replay.supervisor.follower import Follower
from flight_replay.supervisor.learned_passes import LearnedPasses, mean_miss_m
from flight_replay.supervisor.mission_phases import fly_mission
from flight_replay.supervisor.takeoff_phases import change_mode, verify_mission
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor


class WayOfFlying(Protocol):
    """What happens between take-off and RTL."""

    def verify(self) -> None:
        """Check, before arming and again before it begins, that the vehicle will fly what is meant."""

    def begin(self) -> None:
        """After take-off: get to where positions are recorded from."""

    def fly(self, start_s: float) -> str:
        """Fly until the plan ends it; the ``ended`` of ``FlightRecord``.

        Raises:
            FlightEnded: The flight ended otherwise.
        """

    @property
    def waypoints_reached(self) -> int:
        """How many waypoints were reached."""

    def recording_s(self, times_s: Floats) -> Floats | None:
        """The recording's time (n,) that the vehicle was to be at, at its times (n,), if it had one."""


class MissionFlight:
    """The mission on board, in AUTO."""

    def __init__(self, monitor: VehicleMonitor, plan: Plan) -> None:
        self._monitor, self._plan = monitor, plan

    def verify(self) -> None:
        """The mission on board is the one that was uploaded."""
        verify_mission(self._monitor)

    def begin(self) -> None:
        """Enter AUTO."""
        self._monitor.emit(PhaseStarted(Phase.MISSION))
        self._monitor.record_auto(self._plan.mission)
        change_mode(self._monitor, "AUTO")

    def fly(self, start_s: float) -> str:
        """Follow the mission."""
        return fly_mission(self._monitor, self._plan, start_s)

    @property
    def waypoints_reached(self) -> int:
        """How many of the mission's waypoints were reached."""
        return len({seq for seq, _ in self._plan.mission.waypoints} & self._monitor.progress.reached.keys())

    def recording_s(self, times_s: Floats) -> Floats | None:
        """None: a mission is not in step with the recording."""
        return None


class FollowingFlight:
    """The recording, by targets streamed in GUIDED."""

    def __init__(self, monitor: VehicleMonitor, plan: FollowPlan) -> None:
        self._monitor, self._plan = monitor, plan
        self._follower = Follower(plan.reference, plan.max_error_m, plan.tuning)

    def verify(self) -> None:
        """Nothing is on board."""

    def begin(self) -> None:
        """Fly to where the recording begins; follow it and come back for each pass before the last."""
        approach(self._monitor, self._plan)
        passes, learned = self._plan.passes, LearnedPasses(self._plan.reference)
        for number in range(1, passes):
            self._monitor.emit(PhaseStarted(Phase.FOLLOW))
            follow(self._monitor, self._follower, self._plan)
            self._monitor.emit(PassFlown(number, passes, mean_miss_m(self._follower.misses)))
            self._follower = self._taught(learned)
            approach(self._monitor, self._plan)
        self._monitor.emit(PhaseStarted(Phase.FOLLOW))
        self._monitor.record_from_now()

    def _taught(self, learned: LearnedPasses) -> Follower:
        """The follower of the next pass."""
        before, plan = self._follower, self._plan
        knowledge = replace(before.learned, displacement=learned.learn(before.misses))
        return Follower(plan.reference, plan.max_error_m, plan.tuning, knowledge)

    def fly(self, start_s: float) -> str:
        """Stream targets in step with the recording."""
        return follow(self._monitor, self._follower, self._plan)

    @property
    def waypoints_reached(self) -> int:
        """There are none."""
        return 0

    def recording_s(self, times_s: Floats) -> Floats | None:
        """By the reference's clock, which may have waited."""
        clock = np.array(self._follower.clock).reshape(-1, 2)
        if not len(clock):
            return np.full(len(times_s), np.nan)
        return np.asarray(np.interp(times_s, clock[:, 0], clock[:, 1], left=np.nan, right=np.nan))

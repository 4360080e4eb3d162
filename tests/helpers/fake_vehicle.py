"""A scripted vehicle and a virtual clock: the supervisor's flights without MAVLink, in no time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from flight_replay.events import StatusText, VehicleState
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.mission.items import Mission, waypoint
from flight_replay.supervisor.vehicle_interface import (
    Heartbeat,
    MissionCurrent,
    MissionItemReached,
    PrearmStatus,
    Report,
    Request,
    RequestAck,
    Target,
)

CLIMB_M_S = 2.5
GOTO_M_S = 5.0
FALL_M_S = 8.0
LANDED_S = 1.6
TIMEOUT_S = 0.5
FRAME = FlatFrame(47.0, 8.0)


def route(points: int) -> Mission:
    """``points`` waypoints 10 m apart, northwards."""
    return Mission(tuple(waypoint(47.0 + 9e-5 * i, 8.0, 30.0) for i in range(1, points + 1)))


@dataclass
class FakeClock:
    """A clock that only the fake vehicle advances."""

    now_s: float = 1000.0

    def monotonic_s(self) -> float:
        return self.now_s


@dataclass
class FakeVehicle:
    """A simple copter; each test changes one of its rules.

    ``schedule`` holds changes with the wall-clock time since the start at which each is made.
    """

    clock: FakeClock
    speedup: float = 1.0
    points: int = 5
    item_s: float = 4.0
    ready_after_s: float = 3.0
    arm_delay_s: float = 0.5
    refuse_arm: str = ""
    refuse_mode: frozenset[str] = frozenset()
    climbs: bool = True
    verified: bool = True
    reports_reached: bool = True
    silent: bool = False
    reports_clock: bool = True
    heading_deg: float | None = None
    local_position: bool = True
    follows: bool = True
    deaf: bool = False
    altitude_before_arming_m: float = 0.0
    rtl_north_m: float = -math.inf
    """RTL flies as far north as this before it lands; without one it lands where it is."""
    schedule: list[tuple[float, Callable[[], None]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.began_s = self.clock.now_s
        self.since = 50.0, self.clock.now_s
        """Vehicle time and wall-clock time from which the vehicle's clock runs at ``speedup``."""
        self.mode, self.armed, self.altitude_m = "STABILIZE", False, self.altitude_before_arming_m
        self.requested: list[str] = []
        self.queue: list[Report] = []
        self.target_m = 0.0
        self.arms_at_s: float | None = None
        self.auto_s = 0.0
        self.heartbeat_s = 0.0
        self.ground_m = self.rests_s = 0.0
        self.place_m = np.zeros(2)
        self.velocity_m_s = np.zeros(3)
        self.goal_m: Floats | None = None
        self.target: Target | None = None
        self.target_s = 0.0
        self.targets: list[tuple[float, Target]] = []

    @property
    def time_s(self) -> float:
        """The vehicle's clock."""
        time_s, wall_s = self.since
        return time_s + (self.clock.now_s - wall_s) * self.speedup

    @property
    def seq(self) -> int:
        """The item being flown."""
        return min(1 + int(self.auto_s / self.item_s), self.points)

    def reports(self, timeout_s: float) -> Sequence[Report]:
        """One step of at most 0.1 s of wall-clock time."""
        before_s = self.time_s
        self.clock.now_s += min(timeout_s, 0.1)
        while self.schedule and self.clock.now_s - self.began_s >= self.schedule[0][0]:
            self.schedule.pop(0)[1]()
        self.move(self.time_s - before_s)
        self.report()
        reports, self.queue = self.queue, []
        return [] if self.silent else reports

    def move(self, step_s: float) -> None:
        """Fly on for a step of vehicle time; tests replace this, ``land`` and ``report`` by their own."""
        if self.arms_at_s is not None and self.time_s >= self.arms_at_s:
            self.armed, self.arms_at_s = True, None
            if self.altitude_before_arming_m:
                self.altitude_m, self.heartbeat_s = 0.0, self.time_s
                self.queue.append(Heartbeat(self.mode, True))
        if self.armed and self.mode == "GUIDED":
            self._move_guided(step_s)
        if self.mode == "RTL" and self.place_m[0] < self.rtl_north_m:
            self.place_m = self.place_m + np.array([GOTO_M_S * step_s, 0.0])
        elif self.mode in ("RTL", "LAND"):
            self.land(step_s)
        if self.mode == "AUTO":
            seq = self.seq
            self.auto_s += step_s
            if self.reports_reached and (self.seq > seq or self._complete):
                self.queue.append(MissionItemReached(seq))

    def land(self, step_s: float) -> None:
        """Descend to the ground, disarm when at rest there; without motors fall."""
        falls = not self.armed and self.altitude_m > self.ground_m
        self.altitude_m = max(self.ground_m, self.altitude_m - (FALL_M_S if falls else CLIMB_M_S) * step_s)
        self.rests_s = self.rests_s + step_s if self.altitude_m <= self.ground_m else 0.0
        self.armed = self.armed and self.rests_s < LANDED_S

    def _move_guided(self, step_s: float) -> None:
        """Climb; then fly to the goal, or be where the latest target is until it is too old."""
        self.velocity_m_s = np.zeros(3)
        if self.goal_m is None:
            if self.climbs:
                before_m = self.altitude_m
                self.altitude_m = min(self.target_m, before_m + CLIMB_M_S * step_s)
                self.velocity_m_s[2] = (self.altitude_m - before_m) / max(step_s, 1e-6)
        elif self.target is None:
            here = np.array([*self.place_m, self.altitude_m])
            apart_m = self.goal_m - here
            step_m = min(GOTO_M_S * step_s / max(float(np.linalg.norm(apart_m)), 1e-6), 1.0) * apart_m
            self.place_m, self.altitude_m = (here + step_m)[:2], float((here + step_m)[2])
            self.velocity_m_s = step_m / max(step_s, 1e-6)
        elif self.time_s - self.target_s <= TIMEOUT_S and self.follows:
            self.velocity_m_s = np.array(self.target.velocity_m_s)
            at = FRAME.to_metres(self.target.lat_deg, self.target.lon_deg)
            late_s = self.time_s - self.target_s
            self.place_m = at + late_s * self.velocity_m_s[:2]
            self.altitude_m = self.target.alt_m + late_s * float(self.velocity_m_s[2])

    @property
    def _complete(self) -> bool:
        return self.auto_s >= self.points * self.item_s

    def report(self) -> None:
        if self.time_s - self.heartbeat_s >= 1.0:
            self.heartbeat_s = self.time_s
            self.queue.append(Heartbeat(self.mode, self.armed))
            ready = self.time_s - 50.0 >= self.ready_after_s
            self.queue.append(PrearmStatus(ready, "" if ready else "no position yet"))
            seq = self.seq if self.auto_s else 0
            self.queue.append(MissionCurrent(seq, self.points, self._complete))
        if self.reports_clock:
            north = min(self.auto_s / self.item_s, self.points)
            lat_deg, lon_deg = FRAME.to_degrees(self.place_m)
            north_m_s, east_m_s, down_m_s = self.velocity_m_s.tolist()
            self.queue.append(
                VehicleState(
                    self.time_s,
                    float(lat_deg) + 9e-5 * north,
                    float(lon_deg),
                    self.altitude_m,
                    (north_m_s, east_m_s, down_m_s),
                    self.heading_deg,
                    self.mode,
                    self.armed,
                )
            )

    def send_text(self, text: str, severity: int = 3) -> None:
        """Let the vehicle send a status text."""
        self.queue.append(StatusText(severity, text))

    def request_mode(self, mode: str) -> None:
        self.requested.append(mode)
        if mode in self.refuse_mode:
            self.queue.append(RequestAck(Request.MODE, False, "FAILED"))
        elif not self.silent:
            self.mode = mode
            self.queue.append(RequestAck(Request.MODE, True))

    def request_arm(self) -> None:
        self.requested.append("arm")
        if self.refuse_arm:
            self.send_text(self.refuse_arm)
        elif not self.silent:
            self.arms_at_s = self.time_s + self.arm_delay_s
        self.queue.append(RequestAck(Request.ARM, not self.refuse_arm, "FAILED"))

    def request_takeoff(self, altitude_m: float) -> None:
        self.requested.append("takeoff")
        self.target_m = altitude_m

    def request_speed(self, speed_m_s: float) -> None:
        self.requested.append(f"speed {speed_m_s:g}")

    def request_position(self, lat_deg: float, lon_deg: float, alt_m: float) -> None:
        self.requested.append("position")
        self.target = None
        self.goal_m = np.array([*FRAME.to_metres(lat_deg, lon_deg), alt_m])

    def request_speedup(self, speedup: float) -> None:
        self.requested.append(f"speedup {speedup:g}")
        self.since = self.time_s, self.clock.now_s
        self.speedup = speedup

    @property
    def takes_targets(self) -> bool:
        return self.local_position

    def send_target(self, target: Target) -> None:
        self.targets.append((self.time_s, target))
        if self.mode == "GUIDED" and not self.deaf:
            self.target, self.target_s = target, self.time_s

    def round_trip_s(self) -> float:
        return 0.0

    def request_prearm_checks(self) -> None:
        self.requested.append("report")

    def mission_verified(self, while_waiting: Callable[[], None]) -> bool:
        self.requested.append("verify")
        while_waiting()
        return self.verified

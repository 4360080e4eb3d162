"""Missions flown by the flight model alone: mission and limits in, trajectory out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.mission.items import FIRST_SEQ, TAKEOFF_REACHED_SHARE, Mission
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.copter import STEP_S, Copter
from flight_replay.simulator.mission.local_items import LocalItem, local_items

# Longer than batteries last: a mission that does not end by then never will.
_LONGEST_S = 14_400.0


class EndlessMissionError(MissionError):
    """A mission takes longer than batteries last."""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Where the vehicle was: columns of shape (n,), SI units, one row per step and the start."""

    time_s: Floats
    north_m: Floats
    east_m: Floats
    up_m: Floats
    north_m_s: Floats
    east_m_s: Floats
    up_m_s: Floats
    heading_deg: Floats
    """Where the nose points, clockwise from north, 0 to 360."""
    course_deg: Floats
    """Where it turns to by itself in AUTO, not a number where the vehicle is too slow to turn."""
    reached_s: dict[int, float]
    """Sequence number of each item that was reached, and when (the last time, if jumped back to)."""
    auto_s: tuple[float, float]
    """When AUTO began, and when its last item was done."""
    has_error: bool = False
    """Whether ArduPilot reports an internal error on a leg, and arms only after a reboot."""

    @property
    def north_east_m(self) -> Floats:
        """Ground positions (n, 2)."""
        return np.column_stack([self.north_m, self.east_m])


class _Recorder:
    """Steps a copter and records where it was."""

    def __init__(self, copter: Copter) -> None:
        self.copter = copter
        self.rows = [copter.motion]
        self.turns_rad = [(copter.yaw_rad, copter.course_rad)]

    def run(self, done: Callable[[], bool]) -> None:
        """Step until ``done``."""
        copter = self.copter
        end = copter.steps + _LONGEST_S / copter.step_s
        while not done():
            copter.step()
            self.rows.append(copter.motion)
            self.turns_rad.append((copter.yaw_rad, copter.course_rad))
            if copter.steps > end:
                raise EndlessMissionError("The mission does not end; remove its endless jumps or delays.")

    def auto(
        self, items: Sequence[LocalItem], start_seq: int
    ) -> tuple[dict[int, float], tuple[float, float]]:
        """Fly a mission to its last item; returns what was reached when, and AUTO's beginning and end."""
        if not self.copter.motors:
            self.copter.arm()
        begin = self.copter.time_s
        run = self.copter.start_auto(items, start_seq)
        self.run(lambda: run.completed or run.loitering or not self.copter.motors)
        return {seq: begin + t for seq, t in run.reached}, (begin, self.copter.time_s)

    def trajectory(
        self, frame: LocalFrame, reached_s: dict[int, float], auto_s: tuple[float, float]
    ) -> Trajectory:
        """What was recorded, in ground metres."""
        columns = np.array(self.rows).T
        ground = frame.to_metres(*_flat(frame).to_degrees(columns[1:3].T))
        up, vn, ve, vu = columns[3:]
        heading, course = np.degrees(self.turns_rad).T % 360.0
        place, velocity = (ground[:, 0], ground[:, 1], up), (vn, ve, vu)
        return Trajectory(
            columns[0], *place, *velocity, heading, course, reached_s, auto_s, self.copter.has_error
        )


def home_frame(mission: Mission) -> LocalFrame:
    """The local frame around a mission's home, or without one around its first waypoint."""
    if mission.home is not None:
        return LocalFrame(mission.home.lat_deg, mission.home.lon_deg)
    for _, item in mission.waypoints:
        return LocalFrame(item.lat_deg, item.lon_deg)
    raise MissionError("The mission has neither home nor waypoint; add a waypoint.")


def _flat(frame: LocalFrame) -> FlatFrame:
    return FlatFrame(frame.lat_deg, frame.lon_deg)


def _items(mission: Mission) -> tuple[LocalItem, ...]:
    items = local_items(mission, _flat(home_frame(mission)), mission.home_item.alt_m)
    for item in items:
        if not item.is_simulated:
            raise MissionError(f"Item {item.seq} (command {item.command}) cannot be simulated; remove it.")
    return items


def _to_flat(mission: Mission, start_m: Vector) -> Vector:
    """A start in ground metres, in ArduPilot's metres."""
    frame = home_frame(mission)
    north, east = _flat(frame).to_metres(*frame.to_degrees(start_m[:2])).tolist()
    return north, east, start_m[2]


def _first_altitude_m(items: Sequence[LocalItem]) -> float:
    """Altitude of the first item that has one."""
    for item in items:
        if item.up_m is not None and item.is_navigation:
            return item.up_m
    raise MissionError("No item of the mission has an altitude; set that of the first waypoint.")


def simulate(  # noqa: PLR0913
    mission: Mission,
    limits: Limits,
    *,
    start_m: Vector | None = None,
    velocity_m_s: Vector = (0.0, 0.0, 0.0),
    wind_m_s: Vector = (0.0, 0.0, 0.0),
    start_seq: int = FIRST_SEQ,
    step_s: float = STEP_S,
) -> Trajectory:
    """Fly a mission in AUTO, from item ``start_seq`` until its last item is done.

    Args:
        mission: what to fly; positions come back in metres around ``home_frame(mission)``.
        limits: what the vehicle's parameters allow.
        start_m: position when AUTO begins; above home at the first item's altitude if None.
        velocity_m_s: velocity when AUTO begins, north, east, up.
        wind_m_s: velocity of the air.
        start_seq: sequence number of the first item to fly.
        step_s: duration of a step.

    Raises:
        MissionError: the mission has no location, never ends, or has an item that cannot be simulated.
    """
    items = _items(mission)
    start = (0.0, 0.0, _first_altitude_m(items)) if start_m is None else _to_flat(mission, start_m)
    recorder = _Recorder(
        Copter(
            limits,
            position_m=start,
            velocity_m_s=velocity_m_s,
            wind_m_s=wind_m_s,
            home_amsl_m=mission.home_item.alt_m,
            step_s=step_s,
        )
    )
    return recorder.trajectory(home_frame(mission), *recorder.auto(items, start_seq))


def simulate_flight(
    mission: Mission,
    limits: Limits,
    *,
    takeoff_m: float | None = None,
    after_s: float = 0.0,
) -> Trajectory:
    """Fly a whole flight: take-off at home in GUIDED, AUTO, ``after_s`` seconds more, RTL until disarmed.

    Args:
        mission: what to fly.
        limits: what the vehicle's parameters allow.
        takeoff_m: altitude of the take-off; that of the first item if None. AUTO begins at 95 % of it.
        after_s: how long to stay in AUTO after the last item.

    Raises:
        MissionError: the mission has no location, never ends, or has an item that cannot be simulated.
    """
    items = _items(mission)
    copter = Copter(limits, home_amsl_m=mission.home_item.alt_m)
    recorder = _Recorder(copter)
    up = _first_altitude_m(items) if takeoff_m is None else takeoff_m
    copter.takeoff(up)
    recorder.run(lambda: copter.position_m[2] >= TAKEOFF_REACHED_SHARE * up)
    reached_s, auto_s = recorder.auto(items, FIRST_SEQ)
    recorder.run(lambda: not copter.motors or copter.time_s >= auto_s[1] + after_s)
    if copter.motors:
        copter.return_home()
        recorder.run(lambda: not copter.motors)
    return recorder.trajectory(home_frame(mission), reached_s, auto_s)

"""The phases of a flight that follows a recording in GUIDED: the way to its begin, and the stream.

Whoever takes the vehicle out of GUIDED has it for good: the first heartbeat that shows another mode
ends the stream, and nothing here asks for GUIDED again.
"""

from __future__ import annotations

from math import hypot

import numpy as np

from flight_replay.events import DistanceToStart, Following, Phase, PhaseStarted, VehicleState
from flight_replay.exceptions import PhaseTimeoutError
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.supervisor import flight_ended
from flight_replay.supervisor.flight_ended import FlightEnded
from flight_replay.supervisor.flight_plan import FollowPlan
from flight_replay.supervisor.follower import LONGEST_GAP_S, OFF_COURSE, TARGET_S, Follower, MotionTarget
from flight_replay.supervisor.motion.height_watch import HeightWatch
from flight_replay.supervisor.speedup_keeper import SpeedupKeeper
from flight_replay.supervisor.timers import Deadline, ProgressTimer, RetryTimer
from flight_replay.supervisor.vehicle_clock import VehicleClock
from flight_replay.supervisor.vehicle_interface import Target
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor

_MIN_MOVE_M = 0.5  # A smaller movement is no progress.
_MIN_ADVANCE_S = 0.5  # Less of the recording is no progress.
_AT_START_M, _AT_REST_M_S = 0.5, 0.2
_RETRY_S = 1.0
_STEP_WALL_S, _MIN_STEP_WALL_S = 0.05, 0.001
_BEYOND_S = 0.3  # The vehicle's last position is a little behind the last target.
_LONGEST_ROUND_TRIP_S = 1.0
_NOT_BACK = "the vehicle does not get back to the recording; check its fence, wind, limits and load"


def approach(monitor: VehicleMonitor, plan: FollowPlan) -> None:
    """Fly to where the reference begins, and come to rest there.

    Raises:
        PhaseTimeoutError: The vehicle stops on the way, or does not tell where its frame is.
        FlightEnded: It disarms or falls, or somebody else takes over.
    """
    monitor.emit(PhaseStarted(Phase.APPROACH))
    reference = plan.reference
    start_m = reference.state(reference.begin_s).position_m
    progress, retry = ProgressTimer(monitor), RetryTimer(monitor)
    height = HeightWatch(monitor, min(plan.takeoff_altitude_m, float(start_m[2])))
    deadline, nearest_m = Deadline(monitor, monitor.deadlines.no_progress_s), np.inf
    while True:
        _check_still_ours(monitor)
        height.check()
        apart_m = float(np.linalg.norm(_position_m(reference, monitor.state) - start_m))
        if _at_rest(monitor, apart_m) and monitor.vehicle.takes_targets:
            break
        if apart_m < nearest_m - _MIN_MOVE_M:
            nearest_m = apart_m
            deadline.restart()
        if deadline.passed:
            raise PhaseTimeoutError(_stopped_on_the_way(monitor, apart_m))
        if retry.due(_RETRY_S):
            _request_start(monitor, plan, start_m)
        if progress.due():
            monitor.emit(DistanceToStart(apart_m))
        monitor.step()
    if plan.approach_m_s is not None:
        monitor.vehicle.request_speed(plan.speed_m_s)


def _at_rest(monitor: VehicleMonitor, apart_m: float) -> bool:
    """Whether the vehicle stands where the reference begins."""
    return apart_m < _AT_START_M and _speed_m_s(monitor.state) < _AT_REST_M_S


def _request_start(monitor: VehicleMonitor, plan: FollowPlan, start_m: Floats) -> None:
    if plan.approach_m_s is not None:
        monitor.vehicle.request_speed(plan.approach_m_s)
    monitor.vehicle.request_position(*_place(plan.reference, start_m))


def _stopped_on_the_way(monitor: VehicleMonitor, apart_m: float) -> str:
    if not monitor.vehicle.takes_targets:
        return "the vehicle does not report its local position (LOCAL_POSITION_NED); check its stream rates"
    return f"the vehicle stopped {apart_m:.1f} m from where the recording begins; check its fence and limits"


def follow(monitor: VehicleMonitor, follower: Follower, plan: FollowPlan) -> str:
    """Stream targets until ``plan`` ends the flight; the ``ended`` of ``FlightRecord``.

    Raises:
        FlightEnded: The flight ended otherwise.
    """
    stream, progress = _Stream(monitor, follower, plan), ProgressTimer(monitor)
    deadline, furthest_s = Deadline(monitor, monitor.deadlines.no_progress_s), -np.inf
    while follower.recording_s < plan.end_s + _BEYOND_S:
        stream.step()
        if follower.recording_s > furthest_s + _MIN_ADVANCE_S:
            furthest_s = follower.recording_s
            deadline.restart()
        if deadline.passed:
            raise FlightEnded("no progress", _NOT_BACK)
        if progress.due():
            monitor.emit(_following(monitor, follower, plan))
    return plan.ended


def _check_still_ours(monitor: VehicleMonitor) -> None:
    if monitor.unexpected_mode:
        _wait_for_verdict(monitor)
    if monitor.certainly_disarmed:
        raise flight_ended.disarmed(monitor.reason)
    monitor.check_position()


def _wait_for_verdict(monitor: VehicleMonitor) -> None:
    """A heartbeat showed another mode: nothing is sent any more, whatever the next ones show.

    Raises:
        FlightEnded: Always.
    """
    mode, deadline = monitor.mode, Deadline(monitor, monitor.deadlines.mode_s)
    while monitor.unexpected_mode and not deadline.passed:
        monitor.step()
    monitor.taken_over = True
    raise flight_ended.pilot(mode)


class _Stream:
    """Targets that are sent as the vehicle's clock runs, each for when it arrives by that clock."""

    def __init__(self, monitor: VehicleMonitor, follower: Follower, plan: FollowPlan) -> None:
        self._monitor, self._follower = monitor, follower
        self._off_course_m = OFF_COURSE * plan.max_error_m
        self._clock = VehicleClock(plan.speedup or 1.0)
        self._keeper = SpeedupKeeper(monitor, self._clock, plan.speedup)
        self._seen: VehicleState | None = None

    def step(self) -> None:
        """Process the next report, if one comes before the next target is due, and send that if it is.

        Raises:
            FlightEnded: The vehicle is off course, or not to be sent targets any more.
        """
        monitor, follower = self._monitor, self._follower
        monitor.step(self._until_next_target_wall_s())
        _check_still_ours(monitor)
        if follower.apart_m > self._off_course_m:
            raise flight_ended.off_course(follower.apart_m, follower.higher_m, monitor.position_jump)
        if monitor.state is not None and monitor.state is not self._seen:
            self._seen = monitor.state
            self._clock.received(self._seen.time_s, monitor.wall_s)
        if monitor.caught_up and self._seen is not None:
            self._send_target(self._seen)

    def _send_target(self, state: VehicleState) -> None:
        """Send the next target if it is time for it."""
        follower, arrives_s = self._follower, self._arrives_s()
        if arrives_s is None:
            return  # Nothing is heard of the vehicle: it stops by itself (GUID_TIMEOUT).
        position_m = _position_m(follower.reference, state)
        velocity_m_s = np.array(state.velocity_m_s)
        gap_s = follower.gap_s(arrives_s)
        if gap_s < TARGET_S and follower.begun:
            return
        if gap_s > LONGEST_GAP_S:
            coasted_m = velocity_m_s * (arrives_s - state.time_s)
            follower.resume(arrives_s, position_m + coasted_m, velocity_m_s)
        else:
            follower.observe(state.time_s, position_m, velocity_m_s)
        self._monitor.vehicle.send_target(_target(follower.reference, follower.target(arrives_s)))
        self._keeper.target_sent(arrives_s, gap_s)

    def _arrives_s(self) -> float | None:
        """When a target sent now arrives, by the vehicle's clock; None if nothing is heard."""
        now_s = self._clock.now_s(self._monitor.wall_s)
        if now_s is None:
            return None
        return now_s + min(self._monitor.vehicle.round_trip_s(), _LONGEST_ROUND_TRIP_S) * self._clock.rate

    def _until_next_target_wall_s(self) -> float:
        """How long to wait for reports before the next target is due."""
        arrives_s = self._arrives_s()
        if arrives_s is None or self._clock.rate <= 0:
            return _STEP_WALL_S
        wait_s = (TARGET_S - self._follower.gap_s(arrives_s)) / self._clock.rate
        return min(max(wait_s, _MIN_STEP_WALL_S), _STEP_WALL_S)


def _following(monitor: VehicleMonitor, follower: Follower, plan: FollowPlan) -> Following:
    recording_s = follower.recording_at_s(monitor.time_s)
    return Following(monitor.time_s, recording_s, plan.end_s, follower.error_m, follower.waiting)


def _position_m(reference: ReferenceMotion, state: VehicleState | None) -> Floats:
    """The vehicle's position (3,) in the reference's frame; far away before the first."""
    if state is None:
        return np.full(3, np.inf)
    north_m, east_m = reference.frame.to_metres(state.lat_deg, state.lon_deg)
    return np.array([north_m, east_m, state.alt_m])


def _speed_m_s(state: VehicleState | None) -> float:
    return np.inf if state is None else hypot(*state.velocity_m_s)


def _place(reference: ReferenceMotion, position_m: Floats) -> tuple[float, float, float]:
    lat_deg, lon_deg = reference.frame.to_degrees(position_m[:2])
    return float(lat_deg), float(lon_deg), float(position_m[2])


def _target(reference: ReferenceMotion, target: MotionTarget) -> Target:
    """A target in degrees: the vehicle's own frame has another origin than the reference's."""
    lat_deg, lon_deg, alt_m = _place(reference, target.position_m)
    velocity, acceleration = target.velocity_m_s.tolist(), target.acceleration_m_s2.tolist()
    return Target(
        lat_deg, lon_deg, alt_m,
        (velocity[0], velocity[1], velocity[2]),
        (acceleration[0], acceleration[1], acceleration[2]),
        target.heading_deg, target.heading_rate_deg_s,
    )  # fmt: skip

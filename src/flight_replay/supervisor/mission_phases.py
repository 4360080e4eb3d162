"""The phases from the start of the mission until the vehicle is in RTL, or landed."""

from __future__ import annotations

import math

from flight_replay.events import (
    DistanceToWaypoint,
    Notice,
    Phase,
    PhaseStarted,
    ReturnCommanded,
    VehicleState,
    Waiting,
)
from flight_replay.geometry.geodesy import ground_distance_m
from flight_replay.mission.items import FIRST_SEQ, Command
from flight_replay.supervisor import flight_ended
from flight_replay.supervisor.flight_ended import FlightEnded, quoted
from flight_replay.supervisor.flight_plan import Plan
from flight_replay.supervisor.motion.fallen import disarm_if_staying, moved_m
from flight_replay.supervisor.motion.height_watch import HeightWatch
from flight_replay.supervisor.timers import RETRY_S, Deadline, ProgressTimer, RetryTimer
from flight_replay.supervisor.vehicle_interface import Request
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor

_MIN_MOVE_M = 0.5  # A smaller movement is no progress.
_ASTRAY_M, _LOST_M = 10.0, 400.0
"""So much farther a vehicle is driven away from where it goes, and from where RTL goes."""
_REASON_S = 2.0  # A reason that is not told by then is not told.
_AT_HOME_M = 10.0  # RTL lands nearer, even where the position estimate is a poor one.
_THERE_M, _LONG_REST_S = 3.0, 10.0  # A waypoint is reached within 2 m, by default.
_AT_REST_S = 1.5  # ArduCopter's land detector waits 1 s, and the motors spin down, before it disarms.
_SANK_M = 1.5  # The pressure, and so the height, changes when motors stop; a fall is longer.
_DESCENT_M_S = 2.5  # RTL and LAND descend more slowly by default.
_UNSEEN_S = 6.0  # Heartbeats lost for longer leave time for a fall from most heights.
_COMMANDS_THAT_WAIT = frozenset(
    {Command.WAYPOINT, Command.SPLINE_WAYPOINT, Command.LOITER_TIME, Command.DELAY}
)
"""Commands whose param1 is a time to wait, seconds."""


def fly_mission(monitor: VehicleMonitor, plan: Plan, start_s: float) -> str:
    """Follow the mission in AUTO until ``plan`` ends it; the ``ended`` of ``FlightRecord``.

    Raises:
        FlightEnded: The mission ended otherwise.
    """
    progress = ProgressTimer(monitor)
    deadline = Deadline(monitor, monitor.deadlines.no_progress_s + _longest_wait_s(plan))
    total, way, rest = None, _Way(), _RestAtTheEnd(monitor, plan)
    height = HeightWatch(
        monitor, min(plan.takeoff_altitude_m, *(at.alt_m for _, at in plan.mission.waypoints))
    )
    while True:
        rest.check()
        height.check()
        monitor.check_position()
        ended = _planned_end(monitor, plan, start_s)
        if ended and not monitor.unexpected_mode:
            return ended
        if monitor.certainly_disarmed:
            raise flight_ended.disarmed(monitor.reason)
        total = total or monitor.mission.total
        if monitor.mission.total != total or monitor.mission_replaced:
            raise FlightEnded(
                "mission changed", "another ground station changed the mission in flight; disconnect it"
            )
        seq, ahead_m = monitor.mission.seq, distance_to_item_m(monitor, plan)
        if way.leads_on(seq, ahead_m or 0.0, monitor.altitude_m):
            deadline.restart()
        if deadline.passed:
            raise FlightEnded("no progress", way.stopped(ahead_m or 0.0))
        if seq >= FIRST_SEQ and progress.due():
            waypoint, waypoints = plan.waypoint_at(seq)
            monitor.emit(DistanceToWaypoint(seq, ahead_m, waypoints, waypoint))
        monitor.step()


class _Way:
    """How far the vehicle has come on its way to an item; what leads away, or to and fro, does not count."""

    def __init__(self) -> None:
        self._seq, self._nearest_m, self._lowest_m, self._highest_m = -1, math.inf, math.inf, -math.inf

    def leads_on(self, seq: int, ahead_m: float, altitude_m: float) -> bool:
        """Whether it goes to another item, comes nearer, or is higher or lower than it was on this way."""
        if seq != self._seq:
            self._seq, self._nearest_m, self._lowest_m, self._highest_m = seq, ahead_m, altitude_m, altitude_m
            return True
        if ahead_m < self._nearest_m - _MIN_MOVE_M:
            self._nearest_m = ahead_m
        elif altitude_m < self._lowest_m - _MIN_MOVE_M:
            self._lowest_m = altitude_m
        elif altitude_m > self._highest_m + _MIN_MOVE_M:
            self._highest_m = altitude_m
        else:
            return False
        return True

    def stopped(self, ahead_m: float) -> str:
        """What a person is told if it does not."""
        if ahead_m > self._nearest_m + _ASTRAY_M:
            return f"the vehicle is driven away from item {self._seq}, {ahead_m:.0f} m by now; check the wind"
        return f"the vehicle stopped on its way to item {self._seq}; find out why"


class _RestAtTheEnd:
    """The vehicle's rest at the last waypoint, which it flies to: a long one tells that it reached it.

    Its one report of that may be lost, and not all firmware tells of missions that are complete.
    """

    def __init__(self, monitor: VehicleMonitor, plan: Plan) -> None:
        self._monitor, self._plan = monitor, plan
        self._last = plan.mission.waypoints[-1][1]
        self._began: tuple[float, VehicleState] | None = None

    def check(self) -> None:
        """The last waypoint is reached if the rest has lasted longer than the hold there."""
        now, up_s = self._monitor.state, self._monitor.link_up_s
        if now is None or not self._is_there(now):
            self._began = None
            return
        if self._began is None or moved_m(now, self._began[1]) > _MIN_MOVE_M:
            self._began = up_s, now
        if up_s - self._began[0] > self._last.hold_s + _LONG_REST_S:
            self._monitor.item_reached(self._plan.last_seq)

    def _is_there(self, now: VehicleState) -> bool:
        last = self._last
        is_at_it = ground_distance_m(now, last) < _THERE_M and abs(now.alt_m - last.alt_m) < _THERE_M
        return is_at_it and self._monitor.mission.seq == self._plan.last_seq


def _planned_end(monitor: VehicleMonitor, plan: Plan, start_s: float) -> str | None:
    if plan.duration_s is None:
        complete = monitor.mission.complete or plan.last_seq in monitor.progress.reached
        return "mission complete" if complete else None
    if monitor.time_s - start_s >= plan.duration_s:
        return "duration"
    return "final waypoint" if monitor.mission.seq >= plan.last_seq else None


def _longest_wait_s(plan: Plan) -> float:
    waits_s = (item.params[0] for item in plan.mission.items if item.command in _COMMANDS_THAT_WAIT)
    return max(waits_s, default=0.0)


def distance_to_item_m(monitor: VehicleMonitor, plan: Plan) -> float | None:
    """Ground distance to the item being flown, metres; None if that item has no position."""
    index = monitor.mission.seq - FIRST_SEQ
    if monitor.state is None or not 0 <= index < len(plan.mission.items):
        return None
    item = plan.mission.items[index]
    return ground_distance_m(monitor.state, item) if item.is_waypoint else None


def command_rtl(monitor: VehicleMonitor, limit_wall_s: float) -> bool:
    """Request RTL until a heartbeat confirms it; whether it did within ``limit_wall_s``.

    Raises:
        FlightEnded: The link stays lost, or somebody else changed the mode: RTL does not overrule them.
    """
    monitor.emit(PhaseStarted(Phase.RETURN))
    monitor.modes.expect_change("RTL")
    monitor.begin_phase()
    began_wall_s, retry = monitor.wall_s, RetryTimer(monitor)
    try:
        while not monitor.modes.changed and monitor.wall_s - began_wall_s < limit_wall_s:
            retry_s = RETRY_S if monitor.requests.accepted(Request.MODE) else 0.0
            if not monitor.mode_in_doubt and retry.due(retry_s):
                monitor.vehicle.request_mode("RTL")
            monitor.step()
    except FlightEnded:
        monitor.emit(ReturnCommanded(False))
        raise
    monitor.rtl_confirmed = monitor.modes.changed
    monitor.emit(ReturnCommanded(monitor.rtl_confirmed))
    return monitor.rtl_confirmed


def wait_landed(monitor: VehicleMonitor, loiter_s: float, rally_limit_m: float) -> None:
    """Follow the vehicle home until it has landed and disarmed; it waits ``loiter_s`` over home.

    It may land at a rally point instead, up to ``rally_limit_m`` away.

    One that fell on its way, and lies on the ground, is told to LAND, in which it disarms.

    Raises:
        FlightEnded: It does not move any more, is driven away, disarmed in the air, was landed
            elsewhere, or ``VehicleMonitor.step`` ends the flight.
    """
    monitor.modes.expect("RTL", "LAND")
    progress, taken_over = ProgressTimer(monitor), _TakenOverOnTheWay(monitor)
    deadline = Deadline(monitor, monitor.deadlines.no_progress_s + loiter_s)
    way, began_m = _WayHome(monitor), monitor.from_home_m
    while not monitor.certainly_disarmed:
        taken_over.check()
        if monitor.from_home_m > began_m + max(rally_limit_m, monitor.home_moved_m) + _LOST_M:
            raise _driven_away(monitor)
        if way.leads_on():
            deadline.restart()
        if deadline.passed:
            is_low = monitor.altitude_m < _THERE_M
            stays = disarm_if_staying(monitor) if is_low and not monitor.taken_over else None
            raise FlightEnded("no progress", stays) if stays else _not_landed(monitor)
        if progress.due():
            where = f"{monitor.altitude_m:.1f} m above home, {monitor.from_home_m:.0f} m away"
            monitor.emit(Waiting(Phase.RETURN, where))
        monitor.step()
    taken_over.check(at_once=True)
    _check_landed(monitor)
    taken_over.check_landed_at_home()


class _TakenOverOnTheWay:
    """Who made LAND of RTL: the status text with a failsafe's reason follows the heartbeat."""

    def __init__(self, monitor: VehicleMonitor) -> None:
        self._monitor = monitor
        self._since_s, self._told, self._failsafe_text = math.inf, False, ""

    def check(self, *, at_once: bool = False) -> None:
        """Tell of it once: when the reason is known, and soon if none is."""
        monitor = self._monitor
        if monitor.mode != "LAND" or self._told:
            return
        monitor.taken_over = True
        self._since_s = min(self._since_s, monitor.link_up_s)
        if at_once or monitor.failsafe_text or monitor.link_up_s - self._since_s > _REASON_S:
            self._told, self._failsafe_text = True, monitor.failsafe_text
            monitor.emit(Notice(flight_ended.not_rtl("LAND", self._failsafe_text), warning=True))

    def check_landed_at_home(self) -> None:
        """Check that a vehicle that was landed instead of coming home is there all the same.

        Raises:
            LandedElsewhere: It is not.
        """
        if self._told and self._monitor.from_home_m > _AT_HOME_M:
            raise flight_ended.landed_elsewhere(self._monitor.from_home_m, self._failsafe_text)


class _WayHome:
    """How far the vehicle has come since RTL: what leads to and fro, or up and down, does not count.

    Slower over the ground than ``_ASTRAY_M`` in the time that is left, the wind drives it, or it hovers.
    """

    def __init__(self, monitor: VehicleMonitor) -> None:
        self._monitor, self._began = monitor, monitor.state
        self._farthest_m = [-math.inf] * 5

    def leads_on(self) -> bool:
        """Whether it is farther from where it began, from home, nearer to it, higher or lower than before."""
        now, from_home_m, leads_on = self._monitor.state, self._monitor.from_home_m, False
        if now is None or self._began is None:
            return False
        apart_m = ground_distance_m(self._began, now)
        over_ground = [(value_m, _ASTRAY_M) for value_m in (apart_m, from_home_m, -from_home_m)]
        for way, (value_m, step_m) in enumerate(
            [*over_ground, (now.alt_m, _MIN_MOVE_M), (-now.alt_m, _MIN_MOVE_M)]
        ):
            if value_m > self._farthest_m[way] + step_m:
                self._farthest_m[way], leads_on = value_m, True
        return leads_on


def _not_landed(monitor: VehicleMonitor) -> FlightEnded:
    reason = quoted(monitor.reason)
    if monitor.from_home_m > _ASTRAY_M and monitor.altitude_m > _THERE_M:
        where = f"{monitor.from_home_m:.0f} m away and {monitor.altitude_m:.0f} m above home"
        return FlightEnded(
            "no progress",
            f"the vehicle does not come home, {where}{reason}; check the wind, and take control with the "
            "transmitter or another ground station",
        )
    return FlightEnded(
        "no progress", f"the vehicle did not land and disarm{reason}; watch it until it has landed"
    )


def _driven_away(monitor: VehicleMonitor) -> FlightEnded:
    return FlightEnded(
        "no progress",
        f"the vehicle is driven away from home, {monitor.from_home_m:.0f} m by now; "
        "take control with the transmitter or another ground station",
    )


def _check_landed(monitor: VehicleMonitor) -> None:
    """Check that a vehicle which disarmed was at rest on the ground, as high as that may be.

    Raises:
        FlightEnded: It was in the air, or nothing tells.
    """
    armed, now, disarmed_s = monitor.armed_state, monitor.state, monitor.modes.disarmed.time_s
    if armed is None or now is None or disarmed_s is None or disarmed_s - armed.time_s > _UNSEEN_S:
        raise flight_ended.disarmed_unseen(monitor.reason)
    unseen_s = max(disarmed_s - armed.time_s - _AT_REST_S, 0.0)
    if armed.alt_m - now.alt_m > _SANK_M + _DESCENT_M_S * unseen_s:
        raise flight_ended.disarmed(monitor.reason)

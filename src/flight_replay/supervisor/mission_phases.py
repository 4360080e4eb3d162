"""From the start of the mission until the vehicle is on its way home, or at home."""

from __future__ import annotations

from flight_replay.events import (
    DistanceToWaypoint,
    Phase,
    PhaseStarted,
    ReturnCommanded,
    VehicleState,
    Waiting,
)
from flight_replay.geometry.geodesy import distance_m
from flight_replay.mission.items import FIRST_SEQ, Command
from flight_replay.supervisor.flight_plan import Plan
from flight_replay.supervisor.interruptions import Interrupted
from flight_replay.supervisor.timers import Deadline, Pace, Repeat
from flight_replay.supervisor.vehicle_interface import Request
from flight_replay.supervisor.vehicle_monitor import Watch

_GAIN_M = 0.5  # Less movement than this is no progress.
_AGAIN_S = 1.2  # Heartbeats show once a second what came of a request that was accepted.
_DOUBT_S = 2.0  # By the clock here: a strange mode that is not told again for so long does not hold RTL up.
_WAITS = frozenset({Command.WAYPOINT, Command.SPLINE_WAYPOINT, Command.LOITER_TIME, Command.DELAY})
"""Commands whose param1 is a time to wait, seconds."""


def fly_mission(watch: Watch, plan: Plan, start_s: float) -> str:
    """Follow the mission in AUTO until ``plan`` has it end; by what it ended."""
    pace = Pace(watch)
    deadline = Deadline(watch, watch.deadlines.no_progress_s + _longest_wait_s(plan))
    items, before = None, (-1, 0.0)
    while True:
        ended = _ended(watch, plan, start_s)
        if ended and not watch.mode_in_doubt:
            return ended
        if watch.surely_disarmed:
            raise Interrupted("disarmed", f"the vehicle disarmed in flight: {watch.reason or 'find out why'}")
        items = items or watch.mission.items
        if watch.mission.items != items or watch.mission_replaced:
            raise Interrupted("mission changed", "another station changed the mission during the flight")
        now = (watch.mission.seq, distance_ahead_m(watch, plan) or 0.0)
        if now[0] != before[0] or abs(now[1] - before[1]) > _GAIN_M:
            before = now
            deadline.restart()
        if deadline.passed:
            raise Interrupted("no progress", f"the vehicle stopped on its way to item {watch.mission.seq}")
        if watch.mission.seq >= FIRST_SEQ and pace.due():
            watch.emit(DistanceToWaypoint(watch.mission.seq, distance_ahead_m(watch, plan), plan.last_seq))
        watch.step()


def _ended(watch: Watch, plan: Plan, start_s: float) -> str | None:
    if plan.duration_s is None:
        over = watch.mission.complete or plan.last_seq in watch.reached
        return "mission complete" if over else None
    if watch.time_s - start_s >= plan.duration_s:
        return "duration"
    return "final waypoint" if watch.mission.seq >= plan.last_seq else None


def _longest_wait_s(plan: Plan) -> float:
    return max((item.params[0] for item in plan.mission.items if item.command in _WAITS), default=0.0)


def distance_ahead_m(watch: Watch, plan: Plan) -> float | None:
    """Ground distance to the item being flown, metres; None where that item is no place."""
    index = watch.mission.seq - FIRST_SEQ
    if watch.state is None or not 0 <= index < len(plan.mission.items):
        return None
    item = plan.mission.items[index]
    if not item.is_place:
        return None
    return float(distance_m(watch.state.lat_deg, watch.state.lon_deg, item.lat_deg, item.lon_deg))


def return_home(watch: Watch, limit_wall_s: float) -> bool:
    """Command RTL until the vehicle confirms it; whether it did in time, by the clock here.

    Raises:
        Interrupted: The link is lost for good, or somebody chose another mode meanwhile: RTL is not
            asked for over their heads.
    """
    watch.emit(PhaseStarted(Phase.RETURN))
    watch.modes.expect_change("RTL")
    watch.forget_reason()
    began_s, repeat = watch.wall_s, Repeat(watch)
    try:
        while not watch.modes.changed and watch.wall_s - began_s < limit_wall_s:
            again_s = _AGAIN_S if watch.requests.accepted(Request.MODE) else 0.0
            in_doubt = watch.mode_in_doubt and watch.modes.strange.lasts_s(watch.wall_s) < _DOUBT_S
            if not in_doubt and repeat.due(again_s):
                watch.vehicle.ask_mode("RTL")
            watch.step()
    except Interrupted:
        watch.emit(ReturnCommanded(False))
        raise
    watch.emit(ReturnCommanded(watch.modes.changed))
    return watch.modes.changed


def wait_landed(watch: Watch) -> None:
    """Follow the vehicle home until it has landed and disarmed."""
    watch.modes.expect("RTL", "LAND")
    pace, deadline = Pace(watch), Deadline(watch, watch.deadlines.no_progress_s)
    before = watch.state
    while watch.armed:
        if watch.state and before and _apart_m(watch.state, before) > _GAIN_M:
            before = watch.state
            deadline.restart()
        if deadline.passed:
            raise Interrupted(
                "no progress", f"the vehicle did not land and disarm; {watch.reason or 'watch it'}"
            )
        if pace.due():
            watch.emit(Waiting(Phase.RETURN, f"{watch.altitude_m:.1f} m above home"))
        watch.step()


def _apart_m(a: VehicleState, b: VehicleState) -> float:
    return float(distance_m(a.lat_deg, a.lon_deg, b.lat_deg, b.lon_deg)) + abs(a.alt_m - b.alt_m)

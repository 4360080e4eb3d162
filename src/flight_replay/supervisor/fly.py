"""The flight, phase by phase, with RTL on every way out once the vehicle may be armed."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from flight_replay.events import (
    Event,
    Listener,
    Notice,
    ReturnCommanded,
    VehicleState,
    combine_listeners,
    ignore,
)
from flight_replay.exceptions import VehicleError
from flight_replay.geometry.arrays import Floats
from flight_replay.logs.track import Track, track_from_columns
from flight_replay.mission.items import FIRST_SEQ
from flight_replay.supervisor import flight_ended
from flight_replay.supervisor.flight_ended import Fallen, FlightEnded, LandedElsewhere
from flight_replay.supervisor.flight_plan import FlightPlan, FlightRecord, FollowPlan, Plan
from flight_replay.supervisor.mission_phases import command_rtl, wait_landed
from flight_replay.supervisor.motion.fallen import disarm_if_staying
from flight_replay.supervisor.takeoff_phases import arm_and_takeoff, change_mode, wait_prearm
from flight_replay.supervisor.vehicle_interface import Clock, Vehicle
from flight_replay.supervisor.vehicle_monitor import ConfirmArming, VehicleMonitor
from flight_replay.supervisor.ways_of_flying import FollowingFlight, MissionFlight, WayOfFlying

_log = logging.getLogger(__name__)

_RTL_ATTEMPTS = 10
_TAKEN_OVER = frozenset({"pilot", "failsafe"})
"""``FlightRecord.ended`` where a pilot or failsafe has control."""
_NO_RTL = frozenset({"link lost", "reboot", "disarmed"})
"""Where nobody wonders that RTL is not confirmed."""
_FALLEN = frozenset({"reboot", "disarmed"})
"""On the way home, too, this is how the flight ended."""


class FlightInterrupted(KeyboardInterrupt):
    """Ctrl-C or its like ended a flight, and RTL was commanded; ``record`` is of the part flown."""

    def __init__(self, record: FlightRecord) -> None:
        super().__init__()
        self.record = record


def fly(
    vehicle: Vehicle,
    clock: Clock,
    plan: Plan | FollowPlan,
    listener: Listener = ignore,
    confirm_arming: ConfirmArming | None = None,
) -> FlightRecord:
    """Fly ``plan``: pre-arm, GUIDED, arm, take-off, then the mission on board or the recording, RTL.

    Once arming was requested, every way out (an error, Ctrl-C, a ``SystemExit`` raised on SIGTERM)
    commands RTL first and emits whether the vehicle confirmed it; only a pilot or a failsafe that
    changed the mode is not overruled, nor one that changed it after RTL was confirmed, nor one whose
    mode was the last heard before the link was lost. The caller emits ``Finished``, after closing the
    vehicle. A flight that reached AUTO, or the recording's begin, returns its record even if it ended
    early: see ``FlightRecord.problem``. ``confirm_arming`` is called before each request to arm.

    A vehicle that has fallen, and that RTL does not move, is told to LAND, in which it disarms.

    Raises:
        PhaseTimeoutError: A phase before that timed out; the message has the vehicle's own reason.
        VehicleError: The vehicle, its pilot or its link ended the flight before that.
        FlightInterrupted: Ctrl-C ended it after that.
    """
    monitor = VehicleMonitor(vehicle, clock, combine_listeners(listener), plan.deadlines)
    monitor.confirm_arming = confirm_arming or monitor.confirm_arming
    way = MissionFlight(monitor, plan) if isinstance(plan, Plan) else FollowingFlight(monitor, plan)
    part = _FlownPart(monitor, way)
    try:
        with _rtl_on_exception(monitor):
            wait_prearm(monitor)
            change_mode(monitor, "GUIDED")
            way.verify()
            arm_and_takeoff(monitor, plan.takeoff_altitude_m)
            way.verify()
            way.begin()
            return _fly_and_return(monitor, way, plan, part)
    except KeyboardInterrupt as interrupt:
        if part.is_over:
            raise FlightInterrupted(part.interrupted_record()) from interrupt
        raise


@contextmanager
def _rtl_on_exception(monitor: VehicleMonitor) -> Iterator[None]:
    """Command RTL when an exception ends the flight and the vehicle may be armed."""
    try:
        yield
    except BaseException as error:
        if not (isinstance(error, FlightEnded) and monitor.taken_over):
            _rtl_despite_errors(monitor, error)
        if isinstance(error, FlightEnded):
            raise VehicleError(error.problem) from error
        raise


class _Undisturbed:
    """A listener that raises nothing, not even to end the program; ``raised`` is what it would have first."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self.raised: BaseException | None = None

    def __call__(self, event: Event) -> None:
        """Pass an event on."""
        try:
            self._listener(event)
        except BaseException as error:
            self.raised = error if self.raised is None else self.raised


def _rtl_despite_errors(monitor: VehicleMonitor, error: BaseException) -> None:
    """Command RTL after an error, if the vehicle may be armed.

    An exception on the way, Ctrl-C included, starts the command again, not the next step; what the
    listener raises waits until RTL is confirmed. ``FlightEnded`` does end it: somebody else took over,
    or the link is gone.
    """
    interrupt: BaseException | None = None
    monitor.emit = listener = _Undisturbed(monitor.emit)
    way_out = _WayOut(monitor, error)
    for _ in range(_RTL_ATTEMPTS):
        try:
            way_out.take()
            break
        except FlightEnded:
            break
        except Exception:
            way_out.failures += 1
            _log.exception("RTL is commanded again after an error")
        except BaseException as stop:
            interrupt = stop
    else:
        monitor.emit(ReturnCommanded(False))
    interrupt = interrupt or listener.raised
    if interrupt is not None:
        raise interrupt


class _WayOut:
    """RTL after an error, which is told first if it is one of the flight; may be taken again."""

    def __init__(self, monitor: VehicleMonitor, error: BaseException) -> None:
        self._monitor, self._error = monitor, error
        self._told = not isinstance(error, FlightEnded | VehicleError)
        self._began_wall_s: float | None = None
        self.failures = 0
        """How often it raised: after twice RTL is requested without the monitor, which may be what fails."""

    def take(self) -> None:
        """Command RTL and wait for it, but not of a vehicle that is disarmed or somebody else's."""
        monitor = self._monitor
        left = monitor.taken_over or monitor.told_to_land or monitor.rtl_confirmed
        if self.failures > 1 and not left:
            monitor.vehicle.request_mode("RTL")
        if not monitor.may_be_armed:
            return
        if not self._told:
            self._told = True
            monitor.emit(Notice(str(self._error), warning=True))
        if self._began_wall_s is None:
            self._began_wall_s = monitor.wall_s
        _rtl_unless_left(monitor, monitor.deadlines.rtl_wall_s - (monitor.wall_s - self._began_wall_s))
        if isinstance(self._error, Fallen) and monitor.rtl_confirmed and monitor.mode == "RTL":
            _tell(monitor, disarm_if_staying(monitor))


def _tell(monitor: VehicleMonitor, problem: str | None) -> None:
    if problem:
        monitor.emit(Notice(problem, warning=True))


def _rtl_unless_left(monitor: VehicleMonitor, limit_wall_s: float) -> None:
    """Command RTL, but not of a vehicle that a pilot or a failsafe has taken over, from RTL too."""
    if monitor.told_to_land:
        monitor.emit(Notice("no RTL is commanded: LAND was, so that it disarms", warning=True))
    elif monitor.rtl_confirmed and monitor.mode != "RTL":
        monitor.emit(Notice(flight_ended.not_rtl(monitor.mode, monitor.failsafe_text), warning=True))
    elif monitor.taken_over:
        monitor.emit(Notice(flight_ended.left_alone(monitor.mode), warning=True))
    else:
        command_rtl(monitor, limit_wall_s)


def _fly_and_return(
    monitor: VehicleMonitor, way: WayOfFlying, plan: FlightPlan, part: _FlownPart
) -> FlightRecord:
    """Supervise the flight and RTL; the record of the flight."""
    problem, landed, fell = None, False, False
    try:
        ended = way.fly(part.begin())
    except FlightEnded as end:
        ended, problem, fell = end.ended, end.problem, isinstance(end, Fallen)
        monitor.emit(Notice(problem, warning=True))
    finally:
        part.end()
    problem = _both(problem, "; ".join(monitor.progress.jumps) or None)
    confirmed = monitor.mode == "RTL" and ended in _TAKEN_OVER
    if not monitor.taken_over:
        confirmed, rtl_problem = _return(monitor)
        if ended == "off course" and monitor.armed is False:
            # It fell before a heartbeat told why.
            fallen = flight_ended.disarmed(monitor.reason)
            ended, problem = fallen.ended, fallen.problem
        problem = problem if ended in _NO_RTL else _both(rtl_problem, problem)
    if confirmed and ended != "disarmed":
        landed, home_problem, ended_on_the_way = _see_home(monitor, plan, fell=fell)
        problem, ended = _both(home_problem, problem), ended_on_the_way or ended
    return part.record(ended, problem, rtl_confirmed=confirmed, landed=landed)


def _see_home(
    monitor: VehicleMonitor, plan: FlightPlan, *, fell: bool
) -> tuple[bool, str | None, str | None]:
    """What is waited for in RTL: whether it has landed, the problem, and how the flight ended if it did."""
    stays = None
    try:
        stays = disarm_if_staying(monitor) if fell else None
        if plan.land and not stays:
            wait_landed(monitor, plan.rtl_loiter_s, plan.rally_limit_m)
            return True, None, None
    except LandedElsewhere as end:
        return True, end.problem, None
    except FlightEnded as end:
        return False, end.problem, end.ended if end.ended in _FALLEN else None
    return False, stays, None


class _FlownPart:
    """What was flown until the flight was over: a vehicle that hears of RTL late flies on, but not for it."""

    def __init__(self, monitor: VehicleMonitor, way: WayOfFlying) -> None:
        self._monitor, self._way = monitor, way
        self._start_s = self._end_s = 0.0
        self._flown: tuple[VehicleState, ...] = ()
        self._reached: tuple[tuple[int, float], ...] = ()
        self._waypoints_reached = 0
        self.is_over = False

    def begin(self) -> float:
        """It begins: the vehicle's time when it did."""
        began_s = self._monitor.auto_start_s
        self._start_s = self._monitor.time_s if began_s is None else began_s
        return self._start_s

    def end(self) -> None:
        """It is over: copies, made at once, as RTL waits for them."""
        self._end_s = self._monitor.time_s
        self._flown = tuple(self._monitor.flown)
        self._reached = tuple(self._monitor.progress.reached.items())
        self._waypoints_reached = self._way.waypoints_reached
        self.is_over = True

    def interrupted_record(self) -> FlightRecord:
        """The record of a flight that Ctrl-C ended."""
        confirmed = self._monitor.rtl_confirmed
        return self.record("interrupted", "the flight was interrupted", rtl_confirmed=confirmed, landed=False)

    def record(self, ended: str, problem: str | None, *, rtl_confirmed: bool, landed: bool) -> FlightRecord:
        """The record of the flight, which ended in that way."""
        track = _track(self._flown)
        reached = [(seq, time_s) for seq, time_s in self._reached if seq >= FIRST_SEQ]
        return FlightRecord(
            waypoints_reached=self._waypoints_reached,
            ended=ended,
            problem=problem,
            auto_start_s=self._start_s,
            auto_s=self._end_s - self._start_s,
            rtl_confirmed=rtl_confirmed,
            landed=landed,
            reached=tuple((seq, _until_next_s(time_s, track.time_s)) for seq, time_s in reached),
            flown=track,
            recording_s=self._way.recording_s(track.time_s),
        )


def _until_next_s(time_s: float, positions_s: Floats) -> float:
    """Halfway from the last position before a report, which has no time of its own, to the next one."""
    following = positions_s[np.searchsorted(positions_s, time_s, side="right") :]
    return (time_s + float(following[0])) / 2 if len(following) else time_s


def _both(latest: str | None, before: str | None) -> str | None:
    """What a person has to know now, and what led there."""
    return f"{latest}; before that {before}" if latest and before else latest or before


def _return(monitor: VehicleMonitor) -> tuple[bool, str | None]:
    """Command RTL when the flight is over: whether it is confirmed, and the problem if it is not."""
    try:
        confirmed = monitor.may_be_armed and command_rtl(monitor, monitor.deadlines.give_up_wall_s)
    except FlightEnded as end:
        if monitor.taken_over:
            return False, end.problem
        confirmed = False
    if confirmed:
        return True, None
    why = f": {monitor.silence}" if monitor.silence else ""
    return False, (
        f"the vehicle did not confirm RTL{why}; take control with the transmitter or another ground station"
    )


def _track(states: tuple[VehicleState, ...]) -> Track:
    """The positions of ``states`` as a track."""
    rows = np.array(  # ``float`` makes an unknown heading, which is None, not a number.
        [(s.time_s, s.lat_deg, s.lon_deg, s.alt_m, s.heading_deg, *s.velocity_m_s) for s in states], float
    ).reshape(-1, 8)
    time_s, lat_deg, lon_deg, alt_m, heading_deg = rows[:, :5].T
    return track_from_columns(
        time_s, lat_deg, lon_deg, alt_m, velocity_m_s=rows[:, 5:], heading_deg=heading_deg
    )

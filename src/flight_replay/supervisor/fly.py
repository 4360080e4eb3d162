"""The flight, phase by phase, with RTL on every way out once the vehicle may be armed."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from flight_replay.errors import VehicleError
from flight_replay.events import Listener, Phase, PhaseStarted, VehicleState, combine_listeners, ignore
from flight_replay.logs.track import Track, track_from_columns
from flight_replay.mission.items import FIRST_SEQ
from flight_replay.supervisor.flight_ended import FlightEnded
from flight_replay.supervisor.flight_plan import FlightRecord, Plan
from flight_replay.supervisor.mission_phases import command_rtl, fly_mission, wait_landed
from flight_replay.supervisor.takeoff_phases import arm_and_takeoff, change_mode, verify_mission, wait_prearm
from flight_replay.supervisor.vehicle_interface import Clock, Vehicle
from flight_replay.supervisor.vehicle_monitor import VehicleMonitor

_log = logging.getLogger(__name__)

_RTL_ATTEMPTS = 10
_TAKEN_OVER = frozenset({"pilot", "failsafe"})
"""``FlightRecord.ended`` where a pilot or failsafe has control: no more commands are sent."""


def fly(vehicle: Vehicle, clock: Clock, plan: Plan, listener: Listener = ignore) -> FlightRecord:
    """Fly ``plan`` on a vehicle with the mission on board: pre-arm, GUIDED, arm, take-off, AUTO, RTL.

    Once arming was requested, every way out (an error, Ctrl-C, a ``SystemExit`` raised on SIGTERM)
    commands RTL first and emits whether the vehicle confirmed it; only a pilot or a failsafe that
    changed the mode is not overruled. The caller emits ``Finished``, after closing the vehicle. A
    flight that reached AUTO returns its record even if it ended early: see ``FlightRecord.problem``.

    Raises:
        PhaseTimeoutError: A phase before AUTO timed out; the message has the vehicle's own reason.
        VehicleError: The vehicle, its pilot or its link ended the flight before AUTO.
    """
    monitor = VehicleMonitor(vehicle, clock, combine_listeners(listener), plan.deadlines)
    with _rtl_on_exception(monitor):
        wait_prearm(monitor)
        change_mode(monitor, "GUIDED")
        verify_mission(monitor)
        arm_and_takeoff(monitor, plan.takeoff_altitude_m)
        verify_mission(monitor)
        monitor.emit(PhaseStarted(Phase.MISSION))
        monitor.record_auto()
        change_mode(monitor, "AUTO")
        return _fly_auto(monitor, plan)


@contextmanager
def _rtl_on_exception(monitor: VehicleMonitor) -> Iterator[None]:
    """Command RTL when an exception ends the flight and the vehicle may be armed."""
    try:
        yield
    except BaseException as error:
        ended = error.ended if isinstance(error, FlightEnded) else ""
        if ended not in _TAKEN_OVER and monitor.may_be_armed:
            _rtl_despite_errors(monitor)
        if isinstance(error, FlightEnded):
            raise VehicleError(error.problem) from error
        raise


def _rtl_despite_errors(monitor: VehicleMonitor) -> None:
    """Command RTL; an exception on the way, Ctrl-C included, starts the command again, not the next step.

    ``FlightEnded`` does end it: somebody else took over, or the link is gone.
    """
    interrupt: BaseException | None = None
    began_wall_s: float | None = None
    for _ in range(_RTL_ATTEMPTS):
        try:
            began_wall_s = monitor.wall_s if began_wall_s is None else began_wall_s
            command_rtl(monitor, monitor.deadlines.rtl_wall_s - (monitor.wall_s - began_wall_s))
            break
        except FlightEnded:
            break
        except Exception:
            _log.exception("RTL is commanded again after an error")
        except BaseException as error:
            interrupt = error
    if interrupt is not None:
        raise interrupt


def _fly_auto(monitor: VehicleMonitor, plan: Plan) -> FlightRecord:
    """Supervise AUTO and RTL; the record of the flight."""
    start_s = monitor.auto_start_s if monitor.auto_start_s is not None else monitor.time_s
    problem, landed = None, False
    try:
        ended = fly_mission(monitor, plan, start_s)
    except FlightEnded as end:
        ended, problem = end.ended, end.problem
    end_s, flown = monitor.time_s, tuple(monitor.flown)
    confirmed = monitor.mode == "RTL"
    if ended not in _TAKEN_OVER:
        confirmed, rtl_problem = _return(monitor)
        problem = problem or rtl_problem
    if plan.land and confirmed:
        try:
            wait_landed(monitor)
            landed = True
        except FlightEnded as end:
            problem = problem or end.problem
    places = {seq for seq, _ in plan.mission.waypoints}
    return FlightRecord(
        waypoints_reached=len(places & monitor.reached.keys()),
        ended=ended,
        problem=problem,
        auto_start_s=start_s,
        auto_s=end_s - start_s,
        rtl_confirmed=confirmed,
        landed=landed,
        reached=tuple((seq, time_s) for seq, time_s in monitor.reached.items() if seq >= FIRST_SEQ),
        flown=_track(flown),
    )


def _return(monitor: VehicleMonitor) -> tuple[bool, str | None]:
    """Command RTL at the end of AUTO: whether it is confirmed, and the problem if it is not."""
    try:
        confirmed = monitor.may_be_armed and command_rtl(monitor, monitor.deadlines.give_up_wall_s)
    except FlightEnded as end:
        if end.ended in _TAKEN_OVER:
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

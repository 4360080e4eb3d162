"""The flight as a story, and the promise that whatever is in the air is sent home."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress

import numpy as np

from flight_replay.errors import VehicleError
from flight_replay.events import Event, Listener, Phase, PhaseStarted, VehicleState, ignore
from flight_replay.logs.track import Track, track_from_columns
from flight_replay.mission.items import FIRST_SEQ
from flight_replay.supervisor.flight_plan import FlightRecord, Plan
from flight_replay.supervisor.interruptions import Interrupted
from flight_replay.supervisor.mission_phases import fly_mission, return_home, wait_landed
from flight_replay.supervisor.takeoff_phases import change_mode, go_up, verify_mission, wait_ready
from flight_replay.supervisor.vehicle_interface import Clock, Vehicle
from flight_replay.supervisor.vehicle_monitor import Watch

_LET_GO = frozenset({"pilot", "failsafe"})
"""Ends after which the vehicle is somebody else's: it is not commanded any more."""


def fly(vehicle: Vehicle, clock: Clock, plan: Plan, listener: Listener = ignore) -> FlightRecord:
    """Fly ``plan`` on a vehicle whose mission is uploaded: ready, GUIDED, arm, take-off, AUTO, RTL.

    Whatever ends the flight once arming was asked for (an error, Ctrl-C, a ``SystemExit`` raised on
    SIGTERM) commands RTL first and emits whether the vehicle confirmed it; only a pilot or a
    failsafe that changed the mode is not overruled. ``Finished`` is left to the caller, who has the
    vehicle to close first. A flight that reached AUTO is handed back
    even where it ended otherwise than asked: see ``FlightRecord.problem``.

    Raises:
        PhaseTimeoutError: A phase before AUTO did not end in time; the reason is the vehicle's own.
        VehicleError: The vehicle, its pilot or its link ended the flight before AUTO.
    """
    watch = Watch(vehicle, clock, listener, plan.deadlines)
    with _homecoming(watch):
        wait_ready(watch)
        change_mode(watch, "GUIDED")
        verify_mission(watch)
        go_up(watch, plan.takeoff_altitude_m)
        verify_mission(watch)
        watch.emit(PhaseStarted(Phase.MISSION))
        watch.record_auto()
        change_mode(watch, "AUTO")
        return _follow(watch, plan)


@contextmanager
def _homecoming(watch: Watch) -> Iterator[None]:
    """Send home what may be in the air when the flight is left by an exception."""
    try:
        yield
    except Interrupted as turn:
        if turn.ended not in _LET_GO:
            with suppress(Interrupted):
                _send_home(watch, watch.deadlines.return_wall_s)
        raise VehicleError(turn.problem) from turn
    except BaseException:
        watch.emit = _deaf(watch.emit)
        with suppress(Interrupted):
            _send_home(watch, watch.deadlines.return_wall_s)
        raise


def _deaf(listener: Listener) -> Listener:
    """The listener, whose own failure (a pipe that closed, say) must not keep the vehicle in the air."""

    def emit(event: Event) -> None:
        with suppress(Exception):
            listener(event)

    return emit


def _send_home(watch: Watch, limit_wall_s: float) -> bool:
    """Command RTL if the vehicle may be armed; whether it is confirmed.

    Raises:
        Interrupted: As ``return_home``.
    """
    return watch.may_be_armed and return_home(watch, limit_wall_s)


def _follow(watch: Watch, plan: Plan) -> FlightRecord:
    """Supervise AUTO and the way home; what is known of it."""
    start_s = watch.auto_start_s if watch.auto_start_s is not None else watch.time_s
    problem, landed = None, False
    try:
        ended = fly_mission(watch, plan, start_s)
    except Interrupted as turn:
        ended, problem = turn.ended, turn.problem
    auto_s = watch.time_s - start_s
    flown = tuple(watch.flown)
    confirmed = watch.mode == "RTL"
    if ended not in _LET_GO:
        try:
            confirmed = _send_home(watch, watch.deadlines.link_back_s)
        except Interrupted as turn:
            confirmed = False
            problem = problem or (turn.problem if turn.ended in _LET_GO else None)
    if problem is None and not confirmed:
        why = f": {watch.silence}" if watch.silence else ""
        problem = f"the vehicle did not confirm RTL{why}; take control of it with another station"
    if plan.land and confirmed:
        try:
            wait_landed(watch)
            landed = True
        except Interrupted as turn:
            problem = problem or turn.problem
    places = {seq for seq, _ in plan.mission.places}
    return FlightRecord(
        waypoints_reached=len(places & watch.reached.keys()),
        ended=ended,
        problem=problem,
        auto_start_s=start_s,
        auto_s=auto_s,
        rtl_confirmed=confirmed,
        landed=landed,
        reached=tuple((seq, time_s) for seq, time_s in watch.reached.items() if seq >= FIRST_SEQ),
        flown=_track(flown),
    )


def _track(states: tuple[VehicleState, ...]) -> Track:
    """The positions of ``states`` as a track."""
    rows = np.array(
        [(s.time_s, s.lat_deg, s.lon_deg, s.alt_m, *s.velocity_m_s) for s in states], float
    ).reshape(-1, 7)
    return track_from_columns(rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3], velocity_m_s=rows[:, 4:])

"""The flight: get a vehicle, check it, upload the mission, and fly it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from flight_replay import supervisor
from flight_replay.cli.consent import ask_consent
from flight_replay.cli.options import Options
from flight_replay.errors import VehicleError
from flight_replay.events import Finished, Listener, Notice
from flight_replay.output.console.console import Console
from flight_replay.output.outcome import Outcome, compare_flight
from flight_replay.planning.altitude import home_of
from flight_replay.planning.route import Route
from flight_replay.supervisor import FlightRecord, Plan, WallClock

if TYPE_CHECKING:
    from flight_replay.logs.tlog.writer import Recorder
    from flight_replay.vehicle import ConnectedVehicle
    from flight_replay.vehicle.preflight import Briefing

_POSITION_TIMEOUT_S = 120.0


@dataclass(frozen=True, slots=True, eq=False)
class FlightResult:
    """A flight, the vehicle that flew it, and its errors."""

    vehicle: str
    simulated: bool
    record: FlightRecord
    outcome: Outcome


def fly_route(options: Options, route: Route, console: Console, listener: Listener) -> FlightResult:
    """Fly the route on the vehicle that the options name, or on a simulator.

    Raises:
        FlightReplayError: The flight ended before the mission began.
    """
    with ExitStack() as stack:
        recorder = stack.enter_context(_recording(options))
        connection = stack.enter_context(_vehicle_or_simulator(options, route, listener))
        connected = stack.enter_context(_connected(connection, options, listener, recorder))
        _set_speedup(connected, options.speedup)
        _check_before_arming(options, route, connected, console, listener)
        if options.connect is not None:
            _save_mission_on_board(connected, connection, options, listener)
        if route.required_limits:
            stack.enter_context(_raised_limits(connected, route.required_limits))
        connected.upload(route.mission, listener)
        record = supervisor.fly(connected, WallClock(), _plan(options, route), listener)
        identity = connected.identity
    if recorder:
        record = replace(record, problem=record.problem or recorder.problem)
    listener(Finished(record.ended))
    return FlightResult(identity.name, identity.simulated, record, compare_flight(route, record))


@contextmanager
def _recording(options: Options) -> Iterator[Recorder | None]:
    """The recorder of ``--record``."""
    if options.record is None:
        yield None
        return
    from flight_replay.logs.tlog.writer import Recorder

    with Recorder(options.record) as recorder:
        yield recorder


@contextmanager
def _vehicle_or_simulator(options: Options, route: Route, listener: Listener) -> Iterator[str]:
    """The connection string of ``--connect``, or of a simulator that starts where the recording did."""
    if options.connect is not None:
        yield options.connect
        return
    from flight_replay.simulator.autopilot.location import Start
    from flight_replay.vehicle.sitl import simulator

    home = home_of(route.covered)
    start = Start(home.lat_deg, home.lon_deg, home.alt_amsl_m)
    speedup = options.speedup or 1.0
    with simulator(options.sim, options.sitl, start, speedup=speedup, listener=listener) as connection:
        yield connection


@contextmanager
def _connected(
    connection: str, options: Options, listener: Listener, recorder: Recorder | None
) -> Iterator[ConnectedVehicle]:
    """The vehicle behind a connection string, with the ground stations of ``--gcs`` on the same link."""
    from flight_replay import vehicle
    from flight_replay.vehicle.link.ground_stations import ground_stations

    with (
        vehicle.connect(
            connection,
            baud=options.baud,
            listener=listener,
            speedup=options.speedup or 1.0,
            recorder=recorder,
            signing_key=options.signing_key,
        ) as connected,
        ground_stations(connected.link, options.gcs, allow_open=options.gcs_open),
    ):
        yield connected


def _set_speedup(connected: ConnectedVehicle, speedup: float | None) -> None:
    """Set the speedup of a simulated vehicle, or read it if None."""
    if connected.identity.simulated:
        connected.set_speedup(speedup)
    elif speedup not in (None, 1.0):
        raise VehicleError(f"{connected.identity.name} is a real vehicle; leave out --speedup")


def _check_before_arming(
    options: Options, route: Route, connected: ConnectedVehicle, console: Console, listener: Listener
) -> None:
    """Refuse a vehicle or a route that must not be flown; ask for consent to arm a real vehicle."""
    briefing = _briefing(options, route, connected, listener)
    if connected.identity.simulated:
        return
    if options.limits == "recorded":
        raise VehicleError(f"{connected.identity.name} is a real vehicle; leave out --limits recorded")
    for line in briefing.lines:
        console.print(line)
    if not options.yes:
        ask_consent(console)
        # Meanwhile the vehicle may have been moved, or armed.
        _briefing(options, route, connected, listener)


def _briefing(options: Options, route: Route, connected: ConnectedVehicle, listener: Listener) -> Briefing:
    """The preflight check with the vehicle where it is now."""
    from flight_replay.vehicle import preflight

    return preflight.check(
        connected.identity,
        route.mission,
        connected.wait_position(_POSITION_TIMEOUT_S, listener),
        takeoff_altitude_m=options.takeoff_altitude_m,
        max_distance_m=options.max_distance_m,
        areas=connected.fence_areas(),
    )


def _save_mission_on_board(
    connected: ConnectedVehicle, connection: str, options: Options, listener: Listener
) -> None:
    """Save the mission on board before the upload, and show the command that restores it."""
    from flight_replay.cli.restore import restore_command, save_mission_on_board

    path = save_mission_on_board(connected, Path.cwd(), datetime.now())
    if path is not None:
        command = restore_command(path, connection, options.baud, options.signing_key)
        listener(Notice(f"Saved the mission on board to {path}. To restore it, run: {command}"))


def _raised_limits(connected: ConnectedVehicle, limits: Mapping[str, float]) -> AbstractContextManager[None]:
    """Raise the vehicle's limits that are lower than ``limits``, and restore them after the flight."""
    wanted = connected.limits_as_parameters(limits)
    current = connected.parameters(wanted)
    return connected.parameters_set({name: value for name, value in wanted.items() if value > current[name]})


def _plan(options: Options, route: Route) -> Plan:
    return Plan(
        mission=route.mission,
        duration_s=options.duration_s,
        takeoff_altitude_m=options.takeoff_altitude_m,
        land=options.land,
    )

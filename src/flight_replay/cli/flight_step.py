"""The steps in the air: a vehicle or a simulator, the mission on board, the flight, and home."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from flight_replay.cli.consent import ask_consent
from flight_replay.cli.options import Options
from flight_replay.errors import VehicleError
from flight_replay.events import Finished, Listener, Notice
from flight_replay.output.console.console import Console
from flight_replay.output.outcome import Outcome, compare_flight
from flight_replay.planning.altitude import home_of
from flight_replay.planning.route import Route
from flight_replay.supervisor import FlightRecord, Plan, WallClock
from flight_replay.supervisor import fly as supervise

if TYPE_CHECKING:
    from flight_replay.logs.tlog.writer import Recorder
    from flight_replay.vehicle import ConnectedVehicle
    from flight_replay.vehicle.preflight import Briefing

_POSITION_S = 120.0


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """A flight and what flew it."""

    vehicle: str
    simulated: bool
    record: FlightRecord
    outcome: Outcome


def fly(options: Options, route: Route, console: Console, listener: Listener) -> Flown:
    """Fly the route as the options say.

    Raises:
        FlightReplayError: Nothing flew, or the flight ended before the mission began.
    """
    from flight_replay.logs.tlog.writer import Recorder

    with ExitStack() as stack:
        recorder = stack.enter_context(Recorder(options.record)) if options.record else None
        connection = options.connect
        if connection is None:
            connection = stack.enter_context(_simulator(options, route, listener))
        connected = stack.enter_context(_connected(connection, options, listener, recorder))
        _set_pace(connected, options.speedup)
        _check(options, route, connected, console, listener)
        if options.connect is not None:
            _keep_mission(connected, connection, options.baud, listener)
        if route.required_limits:
            stack.enter_context(_raised(connected, route.required_limits))
        connected.upload(route.mission, listener)
        record = supervise(connected, WallClock(), _plan(options, route), listener)
        identity = connected.identity
    if recorder:
        record = replace(record, problem=record.problem or recorder.problem)
    listener(Finished(record.ended))
    return Flown(identity.name, identity.simulated, record, compare_flight(route, record))


def _plan(options: Options, route: Route) -> Plan:
    return Plan(
        mission=route.mission,
        duration_s=options.duration_s,
        takeoff_altitude_m=options.takeoff_altitude_m,
        land=options.land,
    )


def _simulator(options: Options, route: Route, listener: Listener) -> AbstractContextManager[str]:
    """A simulator that starts where the recording did."""
    from flight_replay.simulator.autopilot.location import Start
    from flight_replay.vehicle.sitl import simulator

    home = home_of(route.covered)
    start = Start(home.lat_deg, home.lon_deg, home.alt_amsl_m)
    return simulator(options.sim, options.sitl, start, speedup=options.speedup or 1.0, listener=listener)


@contextmanager
def _connected(
    connection: str, options: Options, listener: Listener, recorder: Recorder | None
) -> Iterator[ConnectedVehicle]:
    """The vehicle behind a connection string, recorded and watched as the options say."""
    from flight_replay import vehicle
    from flight_replay.vehicle.link.ground_stations import ground_stations

    with ExitStack() as stack:
        connected = stack.enter_context(
            vehicle.connect(
                connection,
                baud=options.baud,
                listener=listener,
                speedup=options.speedup or 1.0,
                recorder=recorder,
            )
        )
        stack.enter_context(ground_stations(connected.link, options.gcs))
        yield connected


def _set_pace(connected: ConnectedVehicle, speedup: float | None) -> None:
    """Run a simulated vehicle as fast as asked, or keep pace with it; a real one has its own."""
    if connected.identity.simulated:
        connected.set_speedup(speedup)
    elif speedup not in (None, 1.0):
        raise VehicleError(f"{connected.identity.name} is real and flies no faster: leave out --speedup")


def _check(
    options: Options, route: Route, connected: ConnectedVehicle, console: Console, listener: Listener
) -> None:
    """Refuse what must not be flown, and ask before a real vehicle is."""
    briefing = _briefing(options, route, connected, listener)
    if connected.identity.simulated:
        return
    if options.limits == "recorded":
        raise VehicleError(f"{connected.identity.name} is real: --limits recorded is for simulated vehicles")
    for line in briefing.lines:
        console.print(line)
    if not options.yes:
        ask_consent(console)
        # Who takes the time to think may have carried it elsewhere, or armed it.
        _briefing(options, route, connected, listener)


def _briefing(options: Options, route: Route, connected: ConnectedVehicle, listener: Listener) -> Briefing:
    """Refuse what must not be flown from where the vehicle is now; else, what to know before it is."""
    from flight_replay.vehicle import preflight

    return preflight.check(
        connected.identity,
        route.mission,
        connected.wait_position(_POSITION_S, listener),
        takeoff_altitude_m=options.takeoff_altitude_m,
        max_distance_m=options.max_distance_m,
        areas=connected.fence_areas(),
    )


def _raised(connected: ConnectedVehicle, limits: Mapping[str, float]) -> AbstractContextManager[None]:
    """Raise the vehicle's limits for this flight, where they are lower than these."""
    wanted = connected.limits_as_parameters(limits)
    now = connected.parameters(wanted)
    return connected.parameters_set({name: value for name, value in wanted.items() if value > now[name]})


def _keep_mission(connected: ConnectedVehicle, connection: str, baud: int, listener: Listener) -> None:
    """Save what is on board before it is overwritten, and say how to get it back."""
    from flight_replay.cli.restore import keep_mission, restoring_line

    path = keep_mission(connected, Path.cwd(), datetime.now())
    if path is not None:
        line = restoring_line(path, connection, baud)
        listener(Notice(f"The mission that was on board is kept in {path}; to put it back: {line}"))

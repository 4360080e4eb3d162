"""The flight: get a vehicle, plan for it, check it, upload the mission, and fly it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from flight_replay import signals, supervisor
from flight_replay.cli import vehicle_step
from flight_replay.cli.consent import ArmingConsent
from flight_replay.cli.kept_parameters import tell_of_changed_parameters
from flight_replay.cli.mission_or_motion import FlownAs, flown_as, restore_commands
from flight_replay.cli.options import Options
from flight_replay.events import Finished, Listener, VehicleState
from flight_replay.exceptions import VehicleError
from flight_replay.mission.fence import FenceArea
from flight_replay.mission.items import Home
from flight_replay.output.console.console import Console
from flight_replay.output.outcome import Outcome, compare_flight
from flight_replay.planning.route import Route
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.supervisor import FlightRecord, WallClock

if TYPE_CHECKING:
    from flight_replay.logs.tlog.writer import Recorder
    from flight_replay.vehicle import ConnectedVehicle
    from flight_replay.vehicle.identity import Identity
    from flight_replay.vehicle.preflight import Briefing

_POSITION_TIMEOUT_S = 120.0


@dataclass(frozen=True, slots=True, eq=False)
class FlightResult:
    """A flight, the vehicle that flew it, and its errors."""

    vehicle: str
    simulated: bool
    outcome: Outcome

    @property
    def record(self) -> FlightRecord:
        """How the flight went."""
        return self.outcome.record


class ReplayInterrupted(KeyboardInterrupt):
    """Ctrl-C or its like ended a flight, and RTL was commanded; ``flight`` is the part flown of ``route``."""

    def __init__(self, route: Route, flight: FlightResult) -> None:
        super().__init__()
        self.route, self.flight = route, flight


def fly(
    options: Options,
    home: Home,
    plan: Callable[[VehicleLimits], Route],
    console: Console,
    listener: Listener,
) -> tuple[Route, FlightResult | None]:
    """Plan for the vehicle that the options name, or a simulator, and fly it, but in a dry run.

    Args:
        options: which vehicle, and how to fly it.
        home: where a simulator starts.
        plan: makes the route, once the vehicle's limits are known.
        console: asks for consent.
        listener: gets the events of the flight.

    Raises:
        FlightReplayError: The flight ended before the mission began.
        ReplayInterrupted: Ctrl-C ended it after that.
    """
    try:
        with ExitStack() as stack:
            recorder = stack.enter_context(vehicle_step.recording(options))
            connected, connection = _connected(options, home, listener, recorder, stack)
            identity = connected.identity
            route = plan(vehicle_step.vehicle_limits(connected, options, listener))
            if options.dry_run:
                return route, None
            confirm = _check_before_arming(options, route, connected, console, listener)
            record = _flown(flown_as(options, route), connected, connection, listener, confirm)
    except supervisor.FlightInterrupted as interrupt:
        raise ReplayInterrupted(route, _result(identity, route, interrupt.record)) from interrupt
    if recorder:
        record = replace(record, problem=record.problem or recorder.problem)
    listener(Finished(record.ended, record.problem, record.landed))
    return route, _result(identity, route, record)


def _result(identity: Identity, route: Route, record: FlightRecord) -> FlightResult:
    return FlightResult(identity.name, identity.simulated, compare_flight(route, record))


def _connected(
    options: Options, home: Home, listener: Listener, recorder: Recorder | None, stack: ExitStack
) -> tuple[ConnectedVehicle, str]:
    """The vehicle until ``stack`` closes, and its connection string."""
    connection = stack.enter_context(vehicle_step.vehicle_or_simulator(options, home, listener))
    vehicle = vehicle_step.connected_vehicle(connection, options, listener, recorder)
    connected = stack.enter_context(vehicle)
    if options.connect is not None:
        command = restore_commands(options, connection)
        tell_of_changed_parameters(connected, Path.cwd(), command, listener)
    return connected, connection


def _flown(
    route: FlownAs,
    connected: ConnectedVehicle,
    connection: str,
    listener: Listener,
    confirm: ArmingConsent | None,
) -> FlightRecord:
    """The record of the flight, even if a parameter cannot be put back after it."""
    with signals.not_stopped(), ExitStack() as changed:
        route.prepare(connected, connection, changed, listener)
        record = supervisor.fly(connected, WallClock(), route.plan(connected.identity), listener, confirm)
        try:
            changed.close()
        except VehicleError as error:
            record = replace(record, problem=record.problem or str(error))
    return record


def _check_before_arming(
    options: Options, route: Route, connected: ConnectedVehicle, console: Console, listener: Listener
) -> ArmingConsent | None:
    """Refuse a vehicle or a route that must not be flown; what asks for consent to arm a real vehicle.

    That is asked for when the vehicle is ready to arm, with where it is then.
    """
    flown, areas = flown_as(options, route), connected.fence_areas()
    state = connected.wait_position(_POSITION_TIMEOUT_S, listener)
    briefing = _briefing(options, route, connected, areas, state)
    if connected.identity.simulated:
        return None
    more_lines = flown.briefing_lines()

    def lines(now: VehicleState) -> tuple[str, ...]:
        """Whether the vehicle is armed by now, and by whom, is for the supervisor to say."""
        return (*_briefing(options, route, connected, areas, replace(now, armed=False)).lines, *more_lines)

    if options.yes:
        for line in (*briefing.lines, *more_lines):
            console.print(line)
    return ArmingConsent(console, lines, asks=not options.yes)


def _briefing(
    options: Options,
    route: Route,
    connected: ConnectedVehicle,
    areas: tuple[FenceArea, ...],
    state: VehicleState,
) -> Briefing:
    """The preflight check with the vehicle where it is now."""
    from flight_replay.vehicle import preflight

    return preflight.check(
        connected.identity,
        route.mission,
        state,
        takeoff_altitude_m=options.takeoff_altitude_m,
        max_distance_m=options.max_distance_m,
        areas=areas,
        words=flown_as(options, route).words,
        lands=options.land,
    )

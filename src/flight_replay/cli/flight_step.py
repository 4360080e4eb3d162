"""The flight: get a vehicle, plan for it, check it, upload the mission, and fly it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from flight_replay import signals, supervisor
from flight_replay.cli import vehicle_step
from flight_replay.cli.consent import ArmingConsent
from flight_replay.cli.flight_result import FlightResult, ReplayInterrupted
from flight_replay.cli.kept_parameters import tell_of_changed_parameters
from flight_replay.cli.mission_or_motion import FlownAs, flown_as, restore_commands
from flight_replay.cli.options import Options
from flight_replay.events import Finished, Listener, VehicleState
from flight_replay.exceptions import VehicleError
from flight_replay.mission.fence import FenceArea
from flight_replay.mission.items import Home
from flight_replay.output.console.console import Console
from flight_replay.output.outcome import compare_flight
from flight_replay.planning.route import Route
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.supervisor import FlightRecord, WallClock

if TYPE_CHECKING:
    from flight_replay.logs.tlog.writer import Recorder
    from flight_replay.vehicle import ConnectedVehicle
    from flight_replay.vehicle.preflight import Briefing

_POSITION_TIMEOUT_S = 120.0


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
        ReplayInterrupted: Ctrl-C came after that, until this returns.
    """
    flight: _Flight | None = None
    try:
        with ExitStack() as stack:
            recorder = stack.enter_context(vehicle_step.recording(options))
            connected, connection = _connected(options, home, listener, recorder, stack)
            route = plan(vehicle_step.vehicle_limits(connected, options, listener))
            if options.dry_run:
                return route, None
            confirm = _check_before_arming(options, route, connected, console, listener)
            flight = _Flight(connected, listener)
            flight.fly(flown_as(options, route), connection, confirm)
        flight.finish(None if recorder is None else recorder.problem)
        return route, flight.result(route)
    except BaseException as error:
        if flight is None or flight.record is None or not signals.is_interrupt(error):
            raise
        raise ReplayInterrupted(route, flight.result(route)) from error


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


class _Flight:
    """A flight; ``record`` is kept from when it is over, whatever interrupts what follows."""

    def __init__(self, connected: ConnectedVehicle, listener: Listener) -> None:
        self._connected, self._listener = connected, listener
        self.record: FlightRecord | None = None

    def fly(self, route: FlownAs, connection: str, confirm: ArmingConsent | None) -> None:
        """Fly, and put back what was changed for it."""
        connected, listener = self._connected, self._listener
        with signals.not_stopped(), ExitStack() as changed:
            route.prepare(connected, connection, changed, listener)
            plan = route.plan(connected.identity)
            try:
                self.record = supervisor.fly(connected, WallClock(), plan, listener, confirm)
            except supervisor.FlightInterrupted as interrupt:
                self.record = interrupt.record
                raise
            try:
                changed.close()
            except VehicleError as error:
                self._note(str(error))

    def _note(self, problem: str | None) -> FlightRecord:
        """The record, with a problem that came after the flight if it had none."""
        assert self.record is not None
        self.record = replace(self.record, problem=self.record.problem or problem)
        return self.record

    def finish(self, problem: str | None) -> None:
        """Tell that the flight is over, and how; a problem may come when the vehicle is closed."""
        record = self._note(problem)
        self._listener(Finished(record.ended, record.problem, record.landed))

    def result(self, route: Route) -> FlightResult:
        """The flight and its errors."""
        assert self.record is not None
        identity = self._connected.identity
        return FlightResult(identity.name, identity.simulated, compare_flight(route, self.record))


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

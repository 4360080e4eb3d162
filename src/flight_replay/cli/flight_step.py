"""The flight: get a vehicle, plan for it, check it, upload the mission, and fly it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from flight_replay import supervisor
from flight_replay.cli import vehicle_step
from flight_replay.cli.consent import ask_consent
from flight_replay.cli.options import Options
from flight_replay.errors import MissionError, VehicleError
from flight_replay.events import Finished, Listener, Notice
from flight_replay.mission.items import Home
from flight_replay.output.console.console import Console
from flight_replay.output.json_summary import reference_summary
from flight_replay.output.outcome import Outcome, compare_flight
from flight_replay.planning.route import Route
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.supervisor import FlightRecord, FollowPlan, Plan, WallClock

if TYPE_CHECKING:
    from flight_replay.vehicle import ConnectedVehicle
    from flight_replay.vehicle.identity import Identity
    from flight_replay.vehicle.preflight import Briefing

_POSITION_TIMEOUT_S = 120.0


@dataclass(frozen=True, slots=True, eq=False)
class FlightResult:
    """A flight, the vehicle that flew it, and its errors."""

    vehicle: str
    simulated: bool
    record: FlightRecord
    outcome: Outcome


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
    """
    with ExitStack() as stack:
        recorder = stack.enter_context(vehicle_step.recording(options))
        connection = stack.enter_context(vehicle_step.vehicle_or_simulator(options, home, listener))
        vehicle = vehicle_step.connected_vehicle(connection, options, listener, recorder)
        connected = stack.enter_context(vehicle)
        route = plan(vehicle_step.vehicle_limits(connected, listener))
        if options.dry_run:
            return route, None
        _check_before_arming(options, route, connected, console, listener)
        record = _flown(options, route, connected, connection, listener)
        identity = connected.identity
    if recorder:
        record = replace(record, problem=record.problem or recorder.problem)
    listener(Finished(record.ended))
    outcome = compare_flight(route, record)
    return route, FlightResult(identity.name, identity.simulated, record, outcome)


def _flown(
    options: Options, route: Route, connected: ConnectedVehicle, connection: str, listener: Listener
) -> FlightRecord:
    """The record of the flight, even if a parameter cannot be put back after it."""
    with ExitStack() as changed:
        _prepare(options, route, connected, connection, changed, listener)
        record = supervisor.fly(connected, WallClock(), _plan(options, route, connected.identity), listener)
        try:
            changed.close()
        except VehicleError as error:
            record = replace(record, problem=record.problem or str(error))
    return record


def _prepare(  # noqa: PLR0913, PLR0917
    options: Options,
    route: Route,
    connected: ConnectedVehicle,
    connection: str,
    stack: ExitStack,
    listener: Listener,
) -> None:
    """Get ready what is flown: the mission on board, or a vehicle that brakes when targets stop coming."""
    if route.reference is not None:
        from flight_replay.vehicle.following import parameters_for_following

        stack.enter_context(connected.parameters_set(parameters_for_following(connected)))
        return
    if options.connect is not None:
        _save_mission_on_board(connected, connection, options, listener)
    if route.required_limits:
        stack.enter_context(_raised_limits(connected, route.required_limits))
    connected.upload(route.mission, listener)


def _check_before_arming(
    options: Options, route: Route, connected: ConnectedVehicle, console: Console, listener: Listener
) -> None:
    """Refuse a vehicle or a route that must not be flown; ask for consent to arm a real vehicle."""
    briefing = _briefing(options, route, connected, listener)
    if connected.identity.simulated:
        return
    for line in (*briefing.lines, *_reference_lines(route)):
        console.print(line)
    if not options.yes:
        ask_consent(console)
        # Meanwhile the vehicle may have been moved, or armed.
        _briefing(options, route, connected, listener)


def _reference_lines(route: Route) -> list[str]:
    """What a person has to know of a reference before a real vehicle follows it.

    Raises:
        MissionError: It is faster than the vehicle's own speed setting.
    """
    if route.reference is None:
        return []
    reference, allowed_m_s = reference_summary(route.reference), route.limits.limits.wp_speed_m_s
    if reference["top_speed_m_s"] > allowed_m_s:
        raise MissionError(
            f"the recording reaches {reference['top_speed_m_s']:.1f} m/s, more than the vehicle's own speed "
            f"setting of {allowed_m_s:g} m/s; fly it slower, such as with --speed 0.5x"
        )
    return [
        f"Motion: up to {reference['top_speed_m_s']:.1f} m/s and "
        f"{reference['top_acceleration_m_s2']:.1f} m/s², "
        f"never below {reference['lowest_m']:.0f} m above home"
    ]


def _briefing(options: Options, route: Route, connected: ConnectedVehicle, listener: Listener) -> Briefing:
    """The preflight check with the vehicle where it is now."""
    from flight_replay.vehicle import preflight

    briefing = preflight.check(
        connected.identity,
        route.mission,
        connected.wait_position(_POSITION_TIMEOUT_S, listener),
        takeoff_altitude_m=options.takeoff_altitude_m,
        max_distance_m=options.max_distance_m,
        areas=connected.fence_areas(),
    )
    return briefing if route.reference is None else replace(briefing, waypoints=0)


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


def _plan(options: Options, route: Route, identity: Identity) -> Plan | FollowPlan:
    if route.reference is not None:
        from flight_replay.vehicle.following import leads

        return FollowPlan(
            reference=route.reference,
            recorded_s=float(route.wanted.time_s[-1]),
            duration_s=None if options.duration_s is None else options.duration_s / options.pace,
            max_error_m=options.max_error_m,
            leads=leads(identity),
            approach_m_s=options.speed_m_s if isinstance(options.speed_m_s, float) else None,
            speed_m_s=route.limits.limits.wp_speed_m_s,
            takeoff_altitude_m=options.takeoff_altitude_m,
            land=options.land,
        )
    return Plan(
        mission=route.mission,
        duration_s=options.duration_s,
        takeoff_altitude_m=options.takeoff_altitude_m,
        land=options.land,
    )

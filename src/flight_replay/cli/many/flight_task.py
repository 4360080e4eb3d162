"""The row of one flight: read, planned, and flown again if that is asked: a function that Dask runs."""

from __future__ import annotations

import io
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from flight_replay.cli import plan_step
from flight_replay.cli.many.job import BY_THE_CLOCK, Job
from flight_replay.cli.many.late import teller
from flight_replay.cli.many.log_content import LogContent
from flight_replay.cli.many.survey import LIMIT_S, FoundFlight, log_values
from flight_replay.cli.many.time_limit import limited_to
from flight_replay.cli.options import Options, parse_options
from flight_replay.events import Event, Notice
from flight_replay.exceptions import FlightReplayError
from flight_replay.logs.flights import find_flights
from flight_replay.logs.log_formats import format_title
from flight_replay.logs.vehicles import VehicleId
from flight_replay.output.console.console import PlainConsole
from flight_replay.output.many.flight_columns import Status
from flight_replay.output.many.row_values import (
    Values,
    clean,
    doubt_values,
    flight_values,
    recording_values,
    replay_values,
    route_values,
)
from flight_replay.planning.doubts import doubts
from flight_replay.planning.vehicle_limits import VehicleLimits

if TYPE_CHECKING:
    from flight_replay.planning.route import Route

_STARTING_S = 120.0
_LATE = 3.0


@dataclass(slots=True)
class _Done:
    """What is known so far: a flight that fails late keeps what came before."""

    values: Values = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def listener(self, event: Event) -> None:
        if isinstance(event, Notice) and not event.text.startswith((" Generated", "Generating")):
            self.notes.append(event.text.strip())


def flight_row(log: LogContent, sha256: str, rows: int, flight: FoundFlight, job: Job) -> Values:
    """Plan a flight of a log, and fly it as the job says; what is expected to fail is told in the row.

    Args:
        log: the log.
        sha256: its hash.
        rows: how many rows it gets in all.
        flight: which of its flights.
        job: how.
    """
    with limited_to(limit_s(flight, job), teller(log, flight.key)):
        return _row(log, log_values(log, sha256, rows, job), flight, job)


def limit_s(flight: FoundFlight, job: Job) -> float:
    """The wall-clock time that a flight may take."""
    if job.time_limit_s is not None:
        return job.time_limit_s
    if job.fly not in BY_THE_CLOCK:
        return LIMIT_S
    return LIMIT_S + _LATE * (_STARTING_S + flight.duration_s) / min(job.speedup or 1.0, 20.0)


def _row(log: LogContent, values: Values, flight: FoundFlight, job: Job) -> Values:
    path, which = log.file.path, flight.named(job)
    done = _Done({**values, "command": job.replay_command(path, *which)})
    try:
        options = parse_options(job.replay_arguments(path, *which))
        _replay(options, log, flight, job, done)
    except FlightReplayError as error:
        done.values |= {"status": Status.REFUSED, "problem": str(error)}
    return clean({**done.values, "notes": "; ".join(done.notes)})


def _replay(options: Options, log: LogContent, flight: FoundFlight, job: Job, done: _Done) -> None:
    """Read, plan and fly; what becomes known goes to ``done``.

    Raises:
        FlightReplayError: The flight cannot be planned, or ended before its mission began.
    """
    began_s = time.monotonic()
    recording = log.read(_vehicle(options, flight))
    flights = find_flights(recording.track)
    done.values |= {
        **recording_values(recording),
        **flight_values(recording, flights[flight.number - 1], len(flights)),
        "fit_for_replay": False,
    }
    _, track = plan_step.part_of(options, recording, done.listener)
    said = doubts(recording, flights, track)
    done.values |= doubt_values(said, is_planned=False)
    planner = plan_step.Planner(options, track, done.listener, format_title(recording.format))
    before_s = time.monotonic() - began_s

    def plan(limits: VehicleLimits) -> Route:
        plan_began_s = time.monotonic()
        route = planner.route(limits)
        done.values |= {
            **route_values(route),
            **doubt_values(said, is_planned=True),
            "status": Status.PLANNED,
            "plan_wall_s": before_s + time.monotonic() - plan_began_s,
        }
        return route

    if job.fly in BY_THE_CLOCK:
        _fly_by_the_clock(options, planner, plan, job, done)
    else:
        _plan_or_fly_in_model(options, plan(VehicleLimits()), job, done)


def _vehicle(options: Options, flight: FoundFlight) -> VehicleId | None:
    if options.vehicle is not None:
        return VehicleId(*options.vehicle)
    return VehicleId(flight.system) if flight.several and flight.system is not None else None


def _plan_or_fly_in_model(options: Options, route: Route, job: Job, done: _Done) -> None:
    if job.fly == "none":
        return
    from flight_replay.output.outcome import compare_flight
    from flight_replay.planning.model_flight import fly_in_model

    began_s = time.monotonic()
    record = fly_in_model(route, duration_s=options.duration_s, takeoff_m=options.takeoff_altitude_m)
    done.values |= replay_values("model", "flight model", compare_flight(route, record))
    done.values["fly_wall_s"] = time.monotonic() - began_s


def _fly_by_the_clock(
    options: Options,
    planner: plan_step.Planner,
    plan: Callable[[VehicleLimits], Route],
    job: Job,
    done: _Done,
) -> None:
    """Fly through DroneKit on a simulator that is started for this flight, at ports of its own."""
    from flight_replay.cli import flight_step

    logging.getLogger("dronekit").setLevel(logging.CRITICAL)
    logging.getLogger("autopilot").setLevel(logging.CRITICAL)
    began_s = time.monotonic()
    console = PlainConsole(io.StringIO(), quiet=True)
    _, result = flight_step.fly(options, planner.home, plan, console, done.listener)
    if result is None:
        return
    done.values |= replay_values(job.fly, result.vehicle, result.outcome)
    done.values["fly_wall_s"] = time.monotonic() - began_s

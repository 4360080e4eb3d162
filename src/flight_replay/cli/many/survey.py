"""What a log holds: its hash and the flights of its vehicles. A pure function, which Dask runs."""

from __future__ import annotations

import socket
from dataclasses import dataclass
from importlib.metadata import version

from flight_replay.cli.many.job import Job
from flight_replay.cli.many.late import teller
from flight_replay.cli.many.log_content import LogContent
from flight_replay.cli.many.time_limit import limited_to
from flight_replay.cli.options import Options, parse_options
from flight_replay.exceptions import FlightReplayError, LogError
from flight_replay.logs.flights import find_flights
from flight_replay.logs.recording import Recording
from flight_replay.logs.vehicles import VehicleId
from flight_replay.output.many.flight_columns import Status
from flight_replay.output.many.result_store import FlightKey
from flight_replay.output.many.row_values import Values, clean, doubt_values, recording_values
from flight_replay.planning.doubts import doubts

LIMIT_S = 600.0
"""The time for a flight, or a log, that nothing flies by the clock."""


@dataclass(frozen=True, slots=True)
class FoundFlight:
    """A flight in a log: whose, which, and how long; ``several`` where the log holds other vehicles too."""

    system: int | None
    component: int | None
    number: int
    duration_s: float
    several: bool

    @property
    def key(self) -> FlightKey:
        """What tells it from other flights of the log."""
        return self.system, self.component, self.number

    def named(self, job: Job) -> tuple[int | None, int | None]:
        """The system and number that a command has to name beside the job's own arguments."""
        number = None if "--flight" in job.arguments else self.number
        return (self.system if self.several else None), number


@dataclass(frozen=True, slots=True)
class Survey:
    """What was found in a log.

    ``row`` is that of a log without a flight, or one that cannot be read; ``out_of_sight`` is whether
    the worker does not see it: it has to be sent.
    """

    sha256: str | None = None
    flights: tuple[FoundFlight, ...] = ()
    row: Values | None = None
    out_of_sight: bool = False


def survey(log: LogContent, job: Job) -> Survey:
    """Look through a log."""
    with limited_to(survey_limit_s(job), teller(log, None)):
        return _survey(log, job)


def survey_limit_s(job: Job) -> float:
    """The wall-clock time that looking through a log may take."""
    return job.time_limit_s or LIMIT_S


def _survey(log: LogContent, job: Job) -> Survey:
    if log.is_out_of_sight:
        return Survey(out_of_sight=True)
    sha256: str | None = None
    try:
        sha256 = log.sha256()
        options = parse_options(job.replay_arguments(log.file.path, None, None))
        recordings = _recordings(log, options)
    except FlightReplayError as error:
        return Survey(sha256, row=problem_row(log, sha256, job, Status.UNREADABLE, str(error)))
    flights = _flights(recordings, options)
    if flights:
        return Survey(sha256, flights)
    return Survey(sha256, row=_flightless_row(log, sha256, job, recordings[0], options))


def _recordings(log: LogContent, options: Options) -> list[Recording]:
    """What the log holds of the vehicle that is asked for, or of each that there is."""
    if options.vehicle is not None:
        return [log.read(VehicleId(*options.vehicle))]
    first = log.read(None)
    systems = dict.fromkeys(each.system for each in first.vehicles)
    recordings = [first]
    for system in systems:
        if first.vehicle is not None and system != first.vehicle.system:
            try:
                recordings.append(log.read(VehicleId(system)))
            except LogError:  # it has no usable fix
                continue
    return recordings


def _flights(recordings: list[Recording], options: Options) -> tuple[FoundFlight, ...]:
    return tuple(
        FoundFlight(
            None if recording.vehicle is None else recording.vehicle.system,
            None if recording.vehicle is None else recording.vehicle.component,
            flight.number,
            flight.end_s - flight.start_s,
            len(recordings) > 1,
        )
        for recording in recordings
        for flight in find_flights(recording.track)
        if options.flight in (None, flight.number)
    )


def log_values(log: LogContent, sha256: str | None, rows: int, job: Job) -> Values:
    """What is the same for all rows of a log."""
    return {
        "log": log.file.path,
        "log_sha256": sha256,
        "log_bytes": log.file.bytes,
        "log_modified_ns": log.file.modified_ns,
        "log_rows": rows,
        "options": job.options,
        "options_id": job.options_id,
        "worker": socket.gethostname(),
        "version": version("flight-replay"),
    }


def problem_row(log: LogContent, sha256: str | None, job: Job, status: str, problem: str) -> Values:
    """The row of a log of which nothing else is known."""
    command = job.replay_command(log.file.path, None, None)
    return clean(
        {
            **log_values(log, sha256, 1, job),
            "status": status,
            "problem": problem,
            "fit_for_replay": False,
            "command": command,
        }
    )


def _flightless_row(
    log: LogContent, sha256: str | None, job: Job, recording: Recording, options: Options
) -> Values:
    found = find_flights(recording.track)
    problem = (
        f"there is no flight {options.flight} in the log, which has {len(found)}"
        if found
        else "no flight is found: the vehicle was not armed, or did not move"
    )
    track = recording.track
    return clean(
        {
            **problem_row(log, sha256, job, Status.NO_FLIGHT, problem),
            **recording_values(recording),
            **doubt_values(doubts(recording, found, track), is_planned=False),
            "flights": len(found),
            "start_utc_s": recording.start_utc_s,
            "start_lat_deg": float(track.lat_deg[0]),
            "start_lon_deg": float(track.lon_deg[0]),
        }
    )

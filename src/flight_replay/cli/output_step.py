"""The results of a replay: text, the JSON object, the plot and the report."""

from __future__ import annotations

import json
import logging
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flight_replay.cli.options import Options
from flight_replay.cli.whole_flight import repeat_arguments, whole_flight_command
from flight_replay.exceptions import FlightReplayError
from flight_replay.logs.flights import Flight, find_flights
from flight_replay.logs.sample import default_log
from flight_replay.output.console.console import Console
from flight_replay.output.console.terminal import write_verbatim
from flight_replay.output.info_text import info_lines
from flight_replay.output.json_summary import flight_summary, log_summary, route_summary
from flight_replay.output.result_text import flight_lines, route_lines
from flight_replay.writing.output_files import check_place, check_suffix

if TYPE_CHECKING:
    from flight_replay.cli.flight_result import FlightResult
    from flight_replay.logs.recording import Recording
    from flight_replay.output.event_log import LoggedEvent
    from flight_replay.output.outcome import Outcome
    from flight_replay.planning.route import Route


@dataclass(frozen=True, slots=True, eq=False)
class ReplayResult:
    """Everything that a run has found; ``flight`` is None after a dry run."""

    log: Recording
    flights: tuple[Flight, ...]
    route: Route
    flight: FlightResult | None

    @property
    def outcome(self) -> Outcome | None:
        """How the flight went."""
        return None if self.flight is None else self.flight.outcome


def check_outputs(options: Options) -> None:
    """Refuse output files and connection strings that cannot work, before anything is read or flown.

    Raises:
        FlightReplayError: A file has an unknown suffix, is a folder or cannot be written in its folder, one
            but the recording's is a pipe or device, or a connection string is not valid.
    """
    _check_suffixes(options)
    for file in (*options.save, options.plot, options.report):
        if file:
            check_place(file)
    if options.record:
        check_place(options.record, pipes=True)
    _check_files(options)
    if options.connect is not None:
        from flight_replay.vehicle.link.connection_string import transport_for

        transport_for(options.connect, options.baud)
    if options.gcs:
        from flight_replay.vehicle.link.ground_station_sockets import check_can_listen, check_distinct

        check_distinct(options.connect, options.gcs)
        for station in options.gcs:
            check_can_listen(station, allow_open=options.gcs_open)


def _check_files(options: Options) -> None:
    """Refuse an output that is the log itself or another output, or that exists without ``--force``."""
    log = default_log() if options.log is None else options.log
    seen: dict[object, Path] = {}
    for file in (*options.save, options.plot, options.report, options.record):
        if file is None:
            continue
        if _identity(file) == _identity(log):
            raise FlightReplayError(f"{file} is the log that is replayed; choose another file for it")
        other = seen.setdefault(_identity(file), file)
        if other is not file:
            named = "" if other == file else f", as {other}"
            raise FlightReplayError(f"{file} is written by another option{named}; choose another file for it")
        if file.expanduser().is_file() and not options.force:
            raise FlightReplayError(f"{file} exists; choose another name, or replace it with --force")


def _identity(name: Path | str) -> object:
    """What is equal for two names of one file; hard links too."""
    try:
        status = Path(name).expanduser().stat()
    except OSError:
        return Path(os.path.realpath(Path(name).expanduser()))  # a loop of links is no error here
    return status.st_dev, status.st_ino


def _check_suffixes(options: Options) -> None:
    if options.save:
        from flight_replay.mission import formats

        for path in options.save:
            check_suffix(path, formats.SAVED_SUFFIXES)
    if options.plot:
        from flight_replay.output.charts import plot

        check_suffix(options.plot, plot.SUFFIXES)
    if options.report:
        from flight_replay.output.charts import report

        check_suffix(options.report, report.SUFFIXES)


def print_info(options: Options, recording: Recording, console: Console) -> None:
    """Write what a log holds: the "log" object with ``--json``, otherwise a table."""
    flights = find_flights(recording.track)
    if options.json:
        write_verbatim(sys.stdout, json.dumps({"log": log_summary(recording, flights)}))
        return
    for line in info_lines(recording, flights):
        console.print(line)


def save_charts(
    options: Options, result: ReplayResult, events: Sequence[LoggedEvent], arguments: Sequence[str]
) -> list[str]:
    """Write the plot and the report; returns a sentence for each that could not be written."""
    plot, report, problems = options.plot, options.report, []
    if plot is not None:
        problems += problems_of_writing(plot, lambda: _save_plot(plot, result))
    if report is not None:
        problems += problems_of_writing(report, lambda: _save_report(report, result, events, arguments))
    return problems


def problems_of_writing(path: Path, write: Callable[[], None]) -> list[str]:
    """Write a file after the flight: why it could not be written, if so.

    The flight has been flown: whatever goes wrong with one file, the others are still written.
    """
    try:
        write()
    except FlightReplayError as error:
        return [str(error)]
    except Exception as error:
        logging.getLogger(__name__).exception("cannot write %s", path)
        return [f"cannot write {path}: {type(error).__name__}: {error}"]
    return []


def _save_plot(path: Path, result: ReplayResult) -> None:
    from flight_replay.output.charts.plot import save_plot

    save_plot(path, result.route, result.outcome)


def _save_report(
    path: Path, result: ReplayResult, events: Sequence[LoggedEvent], arguments: Sequence[str]
) -> None:
    from flight_replay.output.charts.report import ReportText, save_report

    text = ReportText(json_object(result), events, repeat_arguments(arguments))
    save_report(path, text, result.route, result.outcome)


def print_result(options: Options, result: ReplayResult, console: Console, arguments: Sequence[str]) -> None:
    """Write the JSON object to standard output with ``--json``, otherwise lines of text to the console."""
    if options.json:
        print_json(result)
    else:
        for line in result_lines(result, arguments):
            console.print(line)


def print_json(result: ReplayResult) -> None:
    """Write the JSON object to standard output."""
    write_verbatim(sys.stdout, json.dumps(json_object(result)))


def json_object(result: ReplayResult) -> dict[str, Any]:
    """The ``--json`` object."""
    flight = result.flight
    return {
        "log": log_summary(result.log, result.flights),
        "route": route_summary(result.route),
        "flight": flight and flight_summary(flight.vehicle, flight.simulated, flight.outcome),
    }


def result_lines(result: ReplayResult, arguments: Sequence[str]) -> list[str]:
    """The result as lines of text, which but for the last, a command, fit a terminal of 80 columns."""
    lines = route_lines(result.route)
    if result.outcome is not None:
        command = whole_flight_command(arguments, result.outcome.coverage.fly_all)
        lines += flight_lines(result.route, result.outcome, command)
    return lines

"""The command line: from a log to a landing, each step one call.

Errors become exit statuses here and nowhere else: 0 the replay ended as asked, 1 an expected failure,
which is one line on stderr, 2 wrong usage, 130 interrupted.
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack
from typing import TYPE_CHECKING

from flight_replay import signals
from flight_replay.cli import output_step, plan_step, save_step
from flight_replay.cli.flight_result import FlightResult, ReplayInterrupted
from flight_replay.cli.map_step import with_live_map
from flight_replay.cli.options import Options, parse_options
from flight_replay.cli.output_step import ReplayResult
from flight_replay.events import Listener, Notice, Relay, combine_listeners
from flight_replay.exceptions import FlightReplayError, failure_text
from flight_replay.logs.log_formats import format_title
from flight_replay.output.console.background_console import BackgroundConsole
from flight_replay.output.console.console import Console, open_console
from flight_replay.output.console.log_lines import log_lines
from flight_replay.output.console.terminal import flush_or_discard, show_cursor, write_error, write_line
from flight_replay.output.event_log import EventLog
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.writing.background import Background, Call

if TYPE_CHECKING:
    from flight_replay.mission.items import Home
    from flight_replay.planning.route import Route

_STREAM_S = 1.0


def main(argv: Sequence[str] | None = None) -> int:
    """Run ``flight-replay``; returns the exit status.

    Args:
        argv: The arguments without the program's name, by default those of this process.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        options = parse_options(arguments)
    except SystemExit as stop:
        lost = flush_or_discard(sys.stdout)
        if lost:
            _report(lost)
        return int(stop.code or bool(lost))
    with signals.as_keyboard_interrupt():
        try:
            return _run(options, arguments)
        except KeyboardInterrupt:
            _report("interrupted", interrupted=True)
            return signals.INTERRUPTED_STATUS


def _run(options: Options, arguments: Sequence[str]) -> int:
    """Replay with a console; returns the exit status, after an error line if it is not 0."""
    try:
        with _console(options) as console:
            problem = replay(options, arguments, console)
    except Exception as error:
        if options.verbose:
            import traceback

            for line in traceback.format_exc().rstrip().split("\n"):
                write_line(sys.stderr, line)
        if not isinstance(error, FlightReplayError) and signals.is_interrupt(error):
            raise KeyboardInterrupt from error
        problem = failure_text(error)
    lost = flush_or_discard(sys.stdout)
    problem = "; ".join(filter(None, [problem, lost])) or None
    if problem is not None:
        _report(problem)
    return 0 if problem is None else 1


def _report(problem: str, *, interrupted: bool = False) -> None:
    """Write the error line."""
    calls: list[Call] = [lambda: write_error(sys.stderr, problem)]
    if interrupted:  # It may have kept the console from doing so.
        calls.append(lambda: show_cursor(sys.stdout, sys.stderr))
    _write_soon(calls)


def _write_soon(calls: Sequence[Call]) -> None:
    """Make calls that write; a terminal or pipe that does not take it does not keep the program."""
    background = Background("last lines", capacity=len(calls))
    for call in calls:
        background.submit(call)
    background.close(_STREAM_S)


def replay(options: Options, arguments: Sequence[str], console: Console) -> str | None:
    """From log to landing; returns the problem of a flight that did not end as asked."""
    output_step.check_outputs(options)
    event_log = EventLog()
    relay = Relay(combine_listeners(console.listener, event_log.listener))
    for sentence in options.without_effect:
        relay(Notice(sentence, warning=True))
    if options.compare or options.info:
        _print_only(options, console, relay)
        return None
    recording, flights, track = plan_step.read_recording(options, relay)
    planner = plan_step.Planner(options, track, relay, format_title(recording.format))
    with ExitStack() as stack:
        stack.enter_context(log_lines(sys.stderr, logging.INFO if options.verbose else logging.CRITICAL))

        def plan(limits: VehicleLimits) -> Route:
            """The route for a vehicle, saved, and on the live map until the results are written."""
            route = planner.route(limits)
            save_step.save_mission(options, route, recording, track)
            relay.target = stack.enter_context(with_live_map(options, route, console, relay.target))
            return route

        def save(result: ReplayResult) -> list[str]:
            """Write the files of a flight; a sentence for each that could not be written."""
            problems = save_step.save_flown(options, result, track)
            return problems + output_step.save_charts(options, result, event_log.entries, arguments)

        try:
            route, flight = _fly(options, planner.home, plan, console, relay)
        except ReplayInterrupted as interrupt:
            result = ReplayResult(recording, flights, interrupt.route, interrupt.flight)
            _save_interrupted(options, result, console, save)
            raise
        result = ReplayResult(recording, flights, route, flight)
        output_step.print_result(options, result, console, arguments)
        problems = [] if flight is None else [flight.record.problem]
        problems += save(result)
    return "; ".join(filter(None, problems)) or None


def _print_only(options: Options, console: Console, listener: Listener) -> None:
    """Print what is asked for instead of a replay: a comparison, or what a log holds."""
    if options.compare:
        from flight_replay.cli.compare_step import compare

        compare(options, console)
    else:
        output_step.print_info(options, plan_step.read(options, listener), console)


def _save_interrupted(
    options: Options, result: ReplayResult, console: Console, save: Callable[[ReplayResult], list[str]]
) -> None:
    """Write what is asked for of an interrupted flight; the next signal ends the program at once."""
    files = [*save_step.files_of_flown(options), *filter(None, (options.plot, options.report))]
    names = ", ".join(map(str, files))
    line = f"Interrupted: writing what was flown to {names}; another Ctrl-C ends the program at once"
    with signals.as_keyboard_interrupt():
        if options.json:
            _write_soon([lambda: output_step.print_json(result)])
        if files:
            console.end_display(_STREAM_S)
            _write_soon([lambda: write_line(sys.stderr, line)])
        for problem in save(result):
            console.listener(Notice(problem, warning=True))


def _fly(
    options: Options,
    home: Home,
    plan: Callable[[VehicleLimits], Route],
    console: Console,
    listener: Listener,
) -> tuple[Route, FlightResult | None]:
    """The route, and how it was flown; a dry run without a vehicle is planned with ArduCopter's defaults."""
    if options.dry_run and options.connect is None:
        return plan(VehicleLimits()), None
    # A dry run does not import half of the program.
    from flight_replay.cli import flight_step

    return flight_step.fly(options, home, plan, console, listener)


def _console(options: Options) -> AbstractContextManager[Console]:
    """The console; on stderr where stdout has the JSON object."""
    stream = sys.stderr if options.json else sys.stdout
    return BackgroundConsole(
        lambda: open_console(stream, quiet=options.quiet, verbose=options.verbose, mode=options.mode)
    )

"""The command line: from a log to a landing, each step one call.

The one place that turns errors into exit statuses: 0 as asked, 1 an expected failure told in one
line on stderr, 2 wrong usage, 130 interrupted.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from types import FrameType
from typing import TYPE_CHECKING

from flight_replay import signals
from flight_replay.cli import output_step, plan_step
from flight_replay.cli.observers import mapped
from flight_replay.cli.options import Options, parse
from flight_replay.cli.output_step import Replay
from flight_replay.errors import FlightReplayError
from flight_replay.events import combine_listeners
from flight_replay.output.console.console import Console, open_console
from flight_replay.output.console.terminal import write_error
from flight_replay.output.event_log import EventLog

if TYPE_CHECKING:
    from flight_replay.cli.flight_step import Flown
    from flight_replay.events import Listener
    from flight_replay.planning.route import Route

_ENDS_WITHIN_S = 10.0


def main(argv: Sequence[str] | None = None) -> int:
    """Run ``flight-replay``; returns the exit status.

    Args:
        argv: The arguments without the program's name, by default those of this process.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        options = parse(arguments)
    except SystemExit as stop:
        return int(stop.code or 0)
    with _ended_like_interrupted():
        try:
            return _run(options, arguments)
        except KeyboardInterrupt:
            write_error(sys.stderr, "interrupted")
            return signals.INTERRUPTED_STATUS


def _run(options: Options, arguments: Sequence[str]) -> int:
    """The replay with its console; the exit status, its one line said."""
    try:
        with _console(options) as console:
            problem = replay(options, arguments, console)
    except Exception as error:
        if options.verbose:
            import traceback

            traceback.print_exc()
        problem = _explained(error)
    _finish_stdout()
    if problem is not None:
        write_error(sys.stderr, problem)
    return 0 if problem is None else 1


def _explained(error: Exception) -> str:
    """The one line for an error; one that nobody expected is a fault of this program."""
    if isinstance(error, FlightReplayError):
        return str(error)
    return f"a fault of flight-replay itself ({type(error).__name__}: {error}); report it, with what -v shows"


def replay(options: Options, arguments: Sequence[str], console: Console) -> str | None:
    """From log to landing; returns what went otherwise than asked, once everything is written down."""
    output_step.check_outputs(options)
    journal = EventLog()
    listener = combine_listeners(console.listener, journal.listener)
    log, flights, track = plan_step.read(options, listener)
    route = plan_step.plan(options, track, listener)
    output_step.save_mission(options, route)
    with mapped(options, route, console, listener) as listener:
        flown = None if options.dry_run else _fly(options, route, console, listener)
        result = Replay(log, flights, route, flown)
        output_step.save_pictures(options, result, journal.entries, arguments)
        _say(options, result, console)
    return flown.record.problem if flown else None


def _fly(options: Options, route: Route, console: Console, listener: Listener) -> Flown:
    # Half of the program is only needed in the air, and only then libraries have something to log.
    import logging

    from flight_replay.cli import flight_step

    logging.basicConfig(level=logging.INFO if options.verbose else logging.CRITICAL)

    return flight_step.fly(options, route, console, listener)


def _say(options: Options, result: Replay, console: Console) -> None:
    """The result: for programs on stdout as JSON, for people in words."""
    if options.json:
        with suppress(BrokenPipeError):
            sys.stdout.write(json.dumps(output_step.summary(result)) + "\n")
    else:
        for line in output_step.words(result):
            console.print(line)


def _finish_stdout() -> None:
    """Write out what is left; a reader that has gone (``| head``) needs no complaint."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _console(options: Options) -> AbstractContextManager[Console]:
    """Lines or a live display for people: on stderr where stdout is for programs."""
    stream = sys.stderr if options.json else sys.stdout
    return open_console(stream, quiet=options.quiet, verbose=options.verbose)


@contextmanager
def _ended_like_interrupted() -> Iterator[None]:
    """Make SIGTERM, and a terminal that is closed, end the program as Ctrl-C does: home first.

    Whoever is impatient, or a terminal that sends several signals, must not keep the vehicle from
    being sent home: while the program ends, more of them change nothing. One that was to be ignored
    (``nohup``) still is.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    interrupted_s = float("-inf")

    def interrupt(_signal: int, _frame: FrameType | None) -> None:
        nonlocal interrupted_s
        if time.monotonic() - interrupted_s > _ENDS_WITHIN_S:
            interrupted_s = time.monotonic()
            raise KeyboardInterrupt

    heard = [
        number for number in signals.TERMINATION_SIGNALS if signal.getsignal(number) is not signal.SIG_IGN
    ]
    before = {number: signal.signal(number, interrupt) for number in heard}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)

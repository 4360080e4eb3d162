"""``flight-replay-many``: from logs to a table of flights, each step one call.

Exit status: 0 every log is done, 1 an expected failure, or a comparison that found something worse, 2 wrong
usage, 130 interrupted.
"""

from __future__ import annotations

import json
import os
import shlex
import signal
import sys
import tempfile
import threading
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, NoReturn

from flight_replay import signals
from flight_replay.cli.many.log_files import LogFile, find_logs
from flight_replay.cli.many.many_options import ManyOptions, parse_many_options
from flight_replay.cli.many.many_progress import RunProgress
from flight_replay.cli.whole_flight import repeat_arguments
from flight_replay.exceptions import FlightReplayError, failure_text
from flight_replay.output.console.terminal import flush_or_discard, write_error, write_line, write_verbatim
from flight_replay.output.many.result_store import ResultStore, went_wrong
from flight_replay.output.many.table_files import check_table_name, rows_of

if TYPE_CHECKING:
    from flight_replay.cli.many.many_run import ManyRun

_NAME = "flight-replay-many"
_TABLE = "flights.csv"
_CANCEL_S = 3.0


def main(argv: Sequence[str] | None = None) -> int:
    """Run ``flight-replay-many``; returns the exit status."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    verbose = False
    try:
        options = parse_many_options(sys.argv[1:] if argv is None else argv)
        verbose = options.verbose
        status = _run(options)
    except SystemExit as stop:
        return int(stop.code or bool(flush_or_discard(sys.stdout)))
    except KeyboardInterrupt:
        status = signals.INTERRUPTED_STATUS
        write_error(sys.stderr, "interrupted", program=_NAME)
    except Exception as error:
        if verbose:
            raise
        status = 1
        write_error(sys.stderr, failure_text(error), program=_NAME)
    lost = flush_or_discard(sys.stdout)
    if lost:
        write_error(sys.stderr, lost, program=_NAME)
    return status or int(bool(lost))


def _run(options: ManyOptions) -> int:
    if options.compare is not None:
        return _compare(options, *options.compare)
    _check_outputs(options)
    found = find_logs(options.paths, sys.stdin or (), (options.out, options.report))
    if found.passed_over and not options.quiet:
        count = sum(found.passed_over.values())
        kinds = ", ".join(f"{suffix} {number}" for suffix, number in found.passed_over.most_common(5))
        write_line(sys.stderr, f"Files passed over, no logs by their names: {count} ({kinds})")
    if not found.files:
        raise FlightReplayError("no log is found; name logs, or folders with logs")
    with ExitStack() as stack:
        out = options.out
        if out is None:
            out = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="flight-replay-"))) / _TABLE
        redo = went_wrong if options.redo_failed else None
        store = ResultStore(out, options.job.options_id, redo=redo)
        stack.callback(store.close)
        _replay_all(options, found.files, store)
        _tell_results(options, store)
    return 0


def _check_outputs(options: ManyOptions) -> None:
    """Refuse what cannot be written, before anything is read."""
    if options.out is not None:
        check_table_name(options.out)
    if options.report is not None:
        from flight_replay.output.many.fleet_report import check_report_name

        check_report_name(options.report, _command(options), replace=options.force)
    if options.out is None or not options.out.expanduser().is_file():
        from flight_replay.cli.many.cluster import check_dask

        check_dask()


def _command(options: ManyOptions) -> str:
    """The command that repeats the run."""
    return shlex.join([_NAME, *repeat_arguments(options.argv)])


def _replay_all(options: ManyOptions, files: Sequence[LogFile], store: ResultStore) -> None:
    """Do what is not done yet, on Dask."""
    from flight_replay.cli.many.cluster import dask_client
    from flight_replay.cli.many.many_run import ManyRun

    if store.found and not options.quiet:
        write_line(sys.stderr, f"Going on with {options.out}: rows that are there: {store.found}")
    if all(store.is_done(each.path, each.bytes, each.modified_ns) for each in files):
        return
    progress = RunProgress(as_json=options.json, quiet=options.quiet)
    _interrupt_on_termination()
    try:
        with dask_client(options.scheduler, options.workers) as client:
            at_once = options.workers if options.scheduler is not None else None
            run = ManyRun(client, options.job, store, progress.row, progress.counts, at_once)
            try:
                run.run(files)
            except KeyboardInterrupt:
                progress.end()
                _leave(run, store)
    finally:
        progress.end()


def _interrupt_on_termination() -> None:
    """Raise KeyboardInterrupt on all termination signals; what is ignored (``nohup``) still is."""

    def interrupt(_signal: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    for number in signals.TERMINATION_SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, interrupt)


def _leave(run: ManyRun, store: ResultStore) -> NoReturn:
    """Keep what is done, and end at once: the workers of this machine end when they notice.

    A scheduler that was here before forgets what is not done; it may not answer.
    """
    signals.ignore()
    cancelling = threading.Thread(target=run.cancel, daemon=True)
    cancelling.start()
    problem = "interrupted; what is done is kept, and the same command goes on"
    try:
        store.close()
    except FlightReplayError as error:
        problem = f"interrupted; {error}"
    cancelling.join(_CANCEL_S)
    write_error(sys.stderr, problem, program=_NAME)
    flush_or_discard(sys.stdout)
    flush_or_discard(sys.stderr)
    os._exit(signals.INTERRUPTED_STATUS)


def _tell_results(options: ManyOptions, store: ResultStore) -> None:
    from flight_replay.output.many.fleet_summary import summary_json, summary_lines, summary_of

    if options.report is not None:
        from flight_replay.output.many.fleet_report import save_fleet_report

        save_fleet_report(options.report, store.rows(), _command(options))
    summary = summary_of(store.rows())
    if options.json:
        write_verbatim(sys.stdout, json.dumps({"summary": summary_json(summary)}))
    elif not options.quiet:
        for line in summary_lines(summary):
            write_line(sys.stdout, line)


def _compare(options: ManyOptions, old: Path, new: Path) -> int:
    """Compare two tables; 1 if a flight became worse."""
    from flight_replay.output.many.fleet_comparison import compare_tables, comparison_json, comparison_lines

    comparison = compare_tables(rows_of(old), rows_of(new), options.tolerance)
    if options.json:
        write_verbatim(sys.stdout, json.dumps({"comparison": comparison_json(comparison)}))
    elif not options.quiet:
        for line in comparison_lines(comparison):
            write_line(sys.stdout, line)
    return int(bool(comparison.worse))


if __name__ == "__main__":
    sys.exit(main())

"""How far a run is, at which rate, and how long it still takes: for a terminal, a log file or a program."""

from __future__ import annotations

import json
import sys
import time
from collections import deque

from flight_replay.cli.many.many_run import Counts
from flight_replay.output.console.terminal import is_capable_terminal, write_line, write_verbatim
from flight_replay.output.many.flight_columns import Row
from flight_replay.output.result_text import duration_text
from flight_replay.writing.counted import counted, counted_of

_TERMINAL_S, _FILE_S, _PROGRAM_S = 0.5, 15.0, 2.0
_WINDOW_S = 60.0
_LEAST_S = 1.0


class RunProgress:
    """Shows a run while it lasts."""

    def __init__(self, *, as_json: bool, quiet: bool) -> None:
        self._json, self._quiet = as_json, quiet
        self._terminal = not as_json and is_capable_terminal(sys.stderr)
        self._every_s = _PROGRAM_S if as_json else _TERMINAL_S if self._terminal else _FILE_S
        self._shown_s = time.monotonic()
        self._samples: deque[tuple[float, int, int]] = deque([(self._shown_s, 0, 0)])

    def row(self, row: Row) -> None:
        """A new row: a line for programs."""
        if self._json:
            write_verbatim(sys.stdout, json.dumps({"row": dict(row)}))

    def counts(self, counts: Counts) -> None:
        """Show how far the run is, now and then."""
        now_s = time.monotonic()
        if (self._quiet and not self._json) or now_s - self._shown_s < self._every_s:
            return
        self._shown_s = now_s
        done = counts.logs_done - counts.done_before
        self._samples.append((now_s, done, counts.rows))
        while now_s - self._samples[0][0] > _WINDOW_S and len(self._samples) > 1:
            self._samples.popleft()
        self._show(counts, *self._rates(now_s, done, counts.rows))

    def _rates(self, now_s: float, done: int, rows: int) -> tuple[float, float]:
        """Logs and flights per second, lately."""
        then_s, then_done, then_rows = self._samples[0]
        passed_s = max(now_s - then_s, _LEAST_S)
        return (done - then_done) / passed_s, (rows - then_rows) / passed_s

    def _show(self, counts: Counts, logs_per_s: float, rows_per_s: float) -> None:
        left_s = (counts.logs - counts.logs_done) / logs_per_s if logs_per_s > 0 else None
        if self._json:
            shown = {
                "logs": counts.logs,
                "logs_done": counts.logs_done,
                "flights": counts.rows,
                "flights_per_s": round(rows_per_s, 3),
                "left_s": None if left_s is None else round(left_s),
            }
            write_verbatim(sys.stdout, json.dumps({"progress": shown}))
            return
        left = "" if left_s is None else f", {duration_text(left_s)} left"
        done = f"{counted_of(counts.logs_done, counts.logs, 'log')}, {counted(counts.rows, 'flight')}"
        text = f"{done}, {rows_per_s:.1f} flights/s{left}"
        if self._terminal:
            sys.stderr.write(f"\r\x1b[K{text}")
            sys.stderr.flush()
        else:
            write_line(sys.stderr, text)

    def end(self) -> None:
        """Leave the terminal as it was."""
        if self._terminal:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

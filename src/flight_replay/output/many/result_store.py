"""The results of a run over many logs: every row exactly once, and whole after a crash.

A row goes to a journal at once, and from there to the table now and then: the table is always one that
other programs can read. A run that is started again finds what is done by the content of the logs and
the options.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from flight_replay.exceptions import FlightReplayError
from flight_replay.output.many.flight_columns import GOOD, Row
from flight_replay.output.many.journal import Journal
from flight_replay.output.many.table_files import rows_of, write_rows

_LEAST_WAIT_S = 10.0
_WAIT_SHARE = 20.0
"""The table is written again after so many times as long as that takes."""

FlightKey = tuple[int | None, int | None, int | None]
"""A flight within a log: system, component and number, None where the log has none."""
_RowKey = tuple[str, str | None, str | None, FlightKey]


def flight_key(row: Row) -> FlightKey:
    """The flight of a row."""
    return row.get("vehicle_system"), row.get("vehicle_component"), row.get("flight")


@dataclass(slots=True)
class _LogDone:
    """What is done of the log at a path: its size, time and hash, and which rows it has of how many."""

    bytes: int | None
    modified_ns: int | None
    sha256: str | None
    rows: int
    of_rows: int | None


@dataclass(slots=True)
class _Index:
    """What is done with one set of options."""

    paths: dict[str, _LogDone] = field(default_factory=dict)
    flights: defaultdict[str, set[FlightKey]] = field(default_factory=lambda: defaultdict(set))

    def add(self, row: Row) -> None:
        path, sha256 = str(row["log"]), row.get("log_sha256")
        done = self.paths.get(path)
        if done is None or done.sha256 != sha256:
            done = self.paths[path] = _LogDone(None, None, sha256, 0, None)
        done.bytes, done.modified_ns = row.get("log_bytes"), row.get("log_modified_ns")
        done.rows, done.of_rows = done.rows + 1, row.get("log_rows")
        if sha256 is not None:
            self.flights[sha256].add(flight_key(row))


class ResultStore:
    """The table at a path while a run adds to it."""

    def __init__(self, path: Path, options_id: str, *, redo: Callable[[Row], bool] | None = None) -> None:
        """Open a table, or begin one.

        Args:
            path: the table, .parquet or .csv.
            options_id: of the rows that will be added; those of other options stay as they are.
            redo: whether the flight of a row of these options is done again; the row stays until it is.

        Raises:
            FlightReplayError: It cannot be read or written, or another run is writing it.
        """
        self._path, self._options_id = path.expanduser(), options_id
        self._journal = Journal(self._path.with_name(f"{self._path.name}.journal"))
        self._index = _Index()
        self._waiting = 0
        self._written_s, self._wait_s = time.monotonic(), _LEAST_WAIT_S
        self.found = 0
        """How many rows of these options there were when it was opened."""
        try:
            self._load(redo)
        except FlightReplayError:
            self._journal.close(remove=next(self._journal.rows(), None) is None)
            raise

    def _load(self, redo: Callable[[Row], bool] | None) -> None:
        """Put what a crash left in the journal into the table, and see what is done."""
        if next(self._journal.rows(), None) is not None or not self._path.is_file():
            self._write()
        for row in rows_of(self._path):
            if row.get("options_id") == self._options_id and not _is_redone(row, redo):
                self._index.add(row)
                self.found += 1

    def is_done(self, path: str, size: int | None, modified_ns: int | None) -> bool:
        """Whether all rows of the log at a path are there, as far as its size and time tell, if known."""
        done = self._index.paths.get(path)
        return (
            done is not None
            and size is not None
            and (done.bytes, done.modified_ns) == (size, modified_ns)
            and done.sha256 is not None
            and done.rows == done.of_rows
        )

    def has_flight(self, sha256: str, flight: FlightKey) -> bool:
        """Whether a flight of a log of that content is done, wherever the log was."""
        return flight in self._index.flights.get(sha256, ())

    def add(self, row: Row) -> None:
        """Add a row.

        Raises:
            FlightReplayError: The disk is full.
        """
        self._journal.append(row)
        self._index.add(row)
        self._waiting += 1
        if time.monotonic() - self._written_s > self._wait_s:
            self.write()

    def rows(self) -> Iterator[Row]:
        """All rows of these options; those that wait in the journal are written first."""
        self.write()
        return (row for row in rows_of(self._path) if row.get("options_id") == self._options_id)

    def write(self) -> None:
        """Write the table with all that waits in the journal."""
        if self._waiting:
            self._write()

    def _write(self) -> None:
        began_s = time.monotonic()
        write_rows(self._path, self._all_rows())
        self._journal.clear()
        self._waiting = 0
        self._written_s = time.monotonic()
        self._wait_s = max(_LEAST_WAIT_S, _WAIT_SHARE * (self._written_s - began_s))

    def _all_rows(self) -> Iterator[Row]:
        new = _NewRows(self._journal.rows())
        if self._path.is_file():
            yield from (row for row in rows_of(self._path) if not new.replace(row))
        yield from self._journal.rows()

    def close(self) -> None:
        """Write what waits, and let others write the table."""
        try:
            self.write()
        except BaseException:
            self._journal.close(remove=False)
            raise
        self._journal.close(remove=True)


class _NewRows:
    """The rows that go to a table, and which of its rows they replace."""

    def __init__(self, rows: Iterator[Row]) -> None:
        self._keys, self._logs, self._flights = set[int](), set[int](), set[int]()
        for row in rows:
            self._keys.add(hash(_row_key(row)))
            self._logs.add(hash((str(row["log"]), row.get("options_id"))))
            if row.get("copy_of") is None:
                self._flights.add(hash(_flight_of_log(row)))

    def replace(self, row: Row) -> bool:
        """Whether they are of a row's flight, that failed, or of a log that was not read, or had no flight.

        After a crash between both, a row is in the table and in the journal.
        """
        if hash(_row_key(row)) in self._keys:
            return True
        if row.get("flight") is None:
            return hash((str(row["log"]), row.get("options_id"))) in self._logs
        return went_wrong(row) and hash(_flight_of_log(row)) in self._flights


def _is_redone(row: Row, redo: Callable[[Row], bool] | None) -> bool:
    """Whether a flight is done again: a log that could not be read then may be readable now."""
    return row.get("log_sha256") is None or bool(redo and redo(row))


def _flight_of_log(row: Row) -> tuple[object, ...]:
    """Which flight of which content a row is of, wherever the log was."""
    return row.get("log_sha256"), row.get("options_id"), flight_key(row)


def _row_key(row: Row) -> _RowKey:
    return str(row["log"]), row.get("log_sha256"), row.get("options_id"), flight_key(row)


def went_wrong(row: Row) -> bool:
    """Whether a flight did not go as asked, though its log could be read."""
    return row.get("status") not in GOOD

"""The run: every log is handed to Dask, and every row that comes back to the table.

Only so many tasks are with Dask at a time that the memory here does not grow with the number of logs.
"""

from __future__ import annotations

import shlex
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from flight_replay.cli.many import late
from flight_replay.cli.many.flight_task import flight_row, limit_s
from flight_replay.cli.many.job import Job, path_argument
from flight_replay.cli.many.log_content import MOST_SENT_BYTES, LogContent
from flight_replay.cli.many.log_files import LogFile
from flight_replay.cli.many.survey import (
    FoundFlight,
    Survey,
    log_values,
    problem_row,
    survey,
    survey_limit_s,
)
from flight_replay.exceptions import FlightReplayError
from flight_replay.output.many.flight_columns import Row, Status
from flight_replay.output.many.result_store import FlightKey, ResultStore, flight_key
from flight_replay.output.many.row_values import clean

if TYPE_CHECKING:
    from distributed import Client, Future

_LEAST_TASKS = 8
_TASKS_PER_THREAD = 3
_THREADS_LOOKED_UP_S = 5.0
_RETRIES = 1
_SURVEY, _FLIGHT = 0, 1
"""Priorities: flights that are known go before logs that are not yet looked through."""

NOTHING_FOUND = Survey()
RowListener = Callable[[Row], None]


@dataclass(slots=True)
class Counts:
    """How far a run is; ``done_before`` logs needed nothing any more."""

    logs: int = 0
    done_before: int = 0
    logs_done: int = 0
    rows: int = 0


@dataclass(slots=True)
class _Task:
    """What a future of Dask stands for: the survey of a log, or one of its flights."""

    log: LogContent
    flight: FoundFlight | None = None
    found: Survey = NOTHING_FOUND
    future: Any = None


@dataclass(slots=True)
class ManyRun:
    """One run over some logs.

    ``tell`` gets each new row, ``progress`` the counts, often. ``most_tasks`` is how many flights may be
    with Dask at once; None for as many as keep all threads busy.
    """

    client: Client
    job: Job
    store: ResultStore
    tell: RowListener
    progress: Callable[[Counts], None]
    most_tasks: int | None = None
    counts: Counts = field(default_factory=Counts)
    _tasks: dict[Any, _Task] = field(default_factory=dict)
    _left: dict[str, int] = field(default_factory=dict)
    _flying: set[tuple[str, FlightKey]] = field(default_factory=set)
    _copies: list[tuple[LogFile, str]] = field(default_factory=list)
    _ready: deque[_Task] = field(default_factory=deque)
    _threads: int = 1
    _looked_up_s: float = float("-inf")

    def run(self, files: Sequence[LogFile]) -> None:
        """Do what is not done yet.

        Raises:
            FlightReplayError: The scheduler is lost, or the table cannot be written.
        """
        from distributed import as_completed

        self.counts.logs = len(files)
        waiting = iter(files)
        completed = as_completed()
        self._fill(waiting, completed)
        while self._tasks:
            future = next(completed)
            self._take(future, self._tasks.pop(future.key))
            self._fill(waiting, completed)
            self.progress(self.counts)
        self._add_copies()
        self.progress(self.counts)

    def cancel(self) -> None:
        """Let Dask forget what is not done."""
        self.client.cancel([task.future for task in self._tasks.values()], force=True)

    def _fill(self, waiting: Iterator[LogFile], completed: Any) -> None:
        """Hand Dask work until it has enough: flights that are known first."""
        most = self._most_tasks()
        while len(self._tasks) < most:
            if self._ready:
                task = self._ready.popleft()
            else:
                file = next(waiting, None)
                if file is None:
                    return
                if self.store.is_done(file.path, file.bytes, file.modified_ns):
                    self.counts.done_before += 1
                    self.counts.logs_done += 1
                    continue
                task = _Task(LogContent(file))
            completed.add(self._submit(task))

    def _most_tasks(self) -> int:
        if self.most_tasks is not None:
            return self.most_tasks
        if time.monotonic() - self._looked_up_s > _THREADS_LOOKED_UP_S:
            self._looked_up_s = time.monotonic()
            self._threads = sum(self.client.nthreads().values())
        return max(_LEAST_TASKS, _TASKS_PER_THREAD * self._threads)

    def _submit(self, task: _Task) -> Future:
        work: tuple[Any, ...] = survey, task.log, self.job
        found, priority = task.found, _SURVEY
        if task.flight is not None:
            work = flight_row, task.log, found.sha256, len(found.flights), task.flight, self.job
            priority = _FLIGHT
        future = self.client.submit(*work, pure=False, retries=_RETRIES, priority=priority)
        task.future = future
        self._tasks[future.key] = task
        return future

    def _take(self, future: Future, task: _Task) -> None:
        """What became of a task."""
        if future.status == "cancelled":
            raise FlightReplayError("the Dask scheduler is lost; start it, and start again to go on")
        error = future.exception()
        if error is not None:
            self._take_failure(task, error)
        elif task.flight is None:
            self._take_survey(task.log, future.result())
        else:
            self._take_row(task, future.result())
        future.release()

    def _take_survey(self, log: LogContent, found: Survey) -> None:
        if found.out_of_sight:
            self._send(log)
        elif found.row is not None:
            self._take_single_row(log, found.sha256, found.row)
        else:
            self._take_flights(log, found)

    def _take_single_row(self, log: LogContent, sha256: str | None, row: Row) -> None:
        """The row of a log without flights; another log of the same content may have it already."""
        if sha256 is None or not self.store.has_flight(sha256, flight_key(row)):
            self._add(row)
        else:
            self._copies.append((log.file, sha256))
        self.counts.logs_done += 1

    def _take_flights(self, log: LogContent, found: Survey) -> None:
        sha256 = found.sha256 or ""
        new = [flight for flight in found.flights if not self._is_known(sha256, flight.key)]
        if len(new) < len(found.flights):
            self._copies.append((log.file, sha256))
        self._left[log.file.path] = len(new)
        for flight in new:
            self._flying.add((sha256, flight.key))
            self._ready.append(_Task(log, flight, found))
        if not new:
            self._finish_log(log)

    def _is_known(self, sha256: str, key: FlightKey) -> bool:
        """Whether a flight of that content is done, or is being done now, under whatever path."""
        return self.store.has_flight(sha256, key) or (sha256, key) in self._flying

    def _take_row(self, task: _Task, row: Row) -> None:
        self._add(row)
        self._flying.discard((row.get("log_sha256", ""), flight_key(row)))
        self._left[task.log.file.path] -= 1
        if not self._left[task.log.file.path]:
            self._finish_log(task.log)

    def _finish_log(self, log: LogContent) -> None:
        del self._left[log.file.path]
        self.counts.logs_done += 1

    def _add(self, row: Row) -> None:
        self.store.add(row)
        self.counts.rows += 1
        self.tell(row)

    def _send(self, log: LogContent) -> None:
        """Send a log whose path the workers do not see, if it is small."""
        size = log.file.bytes or 0
        try:
            if size > MOST_SENT_BYTES:
                raise FlightReplayError(
                    f"{log.file.path} is not seen by the workers, and too large to be sent; "
                    "put it in a folder that they share"
                )
            with open(log.file.path, "rb") as file:  # noqa: PTH123
                self._ready.append(_Task(LogContent(log.file, file.read())))
        except (FlightReplayError, OSError) as error:
            self._add(problem_row(log, None, self.job, Status.UNREADABLE, str(error)))
            self.counts.logs_done += 1

    def _take_failure(self, task: _Task, error: BaseException) -> None:
        """A task that was tried again, and failed again: its row says why."""
        from distributed import KilledWorker

        if isinstance(error, KilledWorker):
            status, problem = Status.WORKER_LOST, self._why_lost(task)
        else:
            status, problem = Status.INTERNAL_ERROR, f"{type(error).__name__}: {error}"
        if task.flight is None:
            row = problem_row(task.log, None, self.job, status, problem)
            self._add(clean({**row, "worker": None}))  # it was another machine, or may have been
            self.counts.logs_done += 1
        else:
            self._take_row(task, self._failed_row(task, task.flight, status, problem))

    def _failed_row(self, task: _Task, flight: FoundFlight, status: str, problem: str) -> Row:
        found, path = task.found, task.log.file.path
        return clean(
            {
                **log_values(task.log, found.sha256, len(found.flights), self.job),
                "worker": None,
                "vehicle_system": flight.system,
                "vehicle_component": flight.component,
                "flight": flight.number,
                "duration_s": flight.duration_s,
                "status": status,
                "problem": problem,
                "fit_for_replay": False,
                "command": self.job.replay_command(path, *flight.named(self.job)),
            }
        )

    def _why_lost(self, task: _Task) -> str:
        """Whether the worker ended itself because of the time limit."""
        flight = task.flight
        key = None if flight is None else flight.key
        if late.was_late(self.client.get_events(late.TOPIC), task.log, key):
            limit = survey_limit_s(self.job) if flight is None else limit_s(flight, self.job)
            return f"it took longer than {limit:.0f} s, and so did a second try; allow more with --time-limit"
        return "its worker died, and so did that of a second try: killed, or out of memory"

    def _add_copies(self) -> None:
        """The rows of logs whose content was flown under another path."""
        if not self._copies:
            return
        wanted: dict[str, list[LogFile]] = {}
        for file, sha256 in self._copies:
            wanted.setdefault(sha256, []).append(file)
        mine = [row for row in self.store.rows() if row.get("log_sha256") in wanted]
        there = {(row["log"], flight_key(row)) for row in mine}
        for row in mine:
            for file in wanted[row["log_sha256"]] if "copy_of" not in row else ():
                if (file.path, flight_key(row)) not in there:
                    self._add(_copied(row, file))


def _copied(row: Row, file: LogFile) -> Row:
    """A row for another log of the same content."""
    program, _, *rest = shlex.split(row["command"])
    return clean(
        {
            **row,
            "log": file.path,
            "log_bytes": file.bytes,
            "log_modified_ns": file.modified_ns,
            "copy_of": row["log"],
            "command": shlex.join([program, path_argument(file.path), *rest]),
        }
    )

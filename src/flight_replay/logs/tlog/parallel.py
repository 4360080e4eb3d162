"""Reads the parts of a long file at the same time, each in a process of its own.

Threads gain little here: reading is made of so many short steps of numpy that they would
wait for each other most of the time.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from flight_replay import signals
from flight_replay.logs.tlog.columns import Records

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

PART_LENGTH = 16 << 20  # for less, it is not worth starting another process
_HEAD_START = 8 << 20  # what this process reads while the others start, and later send what they found
_MOST_PARTS = 4


@dataclass(frozen=True, slots=True)
class Part:
    """What a walk found that came into a part of a log at ``enter``, and where it came out: ``leave``.

    ``stop`` is where the part itself ends.
    """

    enter: int
    leave: int
    stop: int
    records: Records


Read = Callable[[int, int, int | None], Part]
"""Reads a part by begin and end; the last is where the walk comes in, None where that must be guessed."""


def read_parts(size: int, read: Read) -> Iterator[Part]:
    """The parts of a file of ``size`` bytes, one after the other.

    A part whose reader could not be started, failed, or had guessed wrong, is read here.
    """
    count = _useful_parts(size)
    shared = size - _HEAD_START if count > 1 else size
    bounds = [0, *(size - shared * left // count for left in range(count - 1, -1, -1))]
    with ExitStack() as stack:
        later = list(pairwise(bounds))[1:]
        readers = [_started(stack, read, begin, end) for begin, end in later]
        part = read(0, bounds[1], 0)
        yield part
        leave = part.leave
        for reader, (begin, end) in zip(readers, later, strict=True):
            guessed = reader.result() if reader else None
            part = guessed if guessed and guessed.enter == leave else read(begin, end, leave)
            leave = part.leave
            yield part


def _useful_parts(size: int) -> int:
    """How many parts to read at a time: one core each, and one only where a fork might not be safe."""
    if size < 2 * PART_LENGTH or not _may_fork():
        return 1
    return min(size // PART_LENGTH, len(os.sched_getaffinity(0)), _MOST_PARTS)


def _may_fork() -> bool:
    """Whether this process can have others read for it.

    A forked process has none of its parent's threads but all of the locks that they held; where
    SIGCHLD is ignored, nobody learns that it has ended; and multiprocessing lets a pool's workers
    have no children.
    """
    if sys.platform != "linux" or threading.active_count() > 1:
        return False
    import multiprocessing  # short logs go without its start-up time

    is_heard = signal.getsignal(signal.SIGCHLD) != signal.SIG_IGN
    return is_heard and not multiprocessing.current_process().daemon


def _started(stack: ExitStack, read: Read, begin: int, end: int) -> _Reader | None:
    """A process that reads a part until the stack is left, None where the system has no room for one."""
    try:
        with _endings_held():
            return stack.enter_context(_Reader(read, begin, end))
    except OSError:
        return None


@contextmanager
def _endings_held() -> Iterator[None]:
    """Let Ctrl-C and the like wait until a new process is known to who has to stop it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals.TERMINATION_SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Reader:
    """A process that reads a part, and is stopped on leaving."""

    def __init__(self, read: Read, begin: int, end: int) -> None:
        import multiprocessing

        context = multiprocessing.get_context("fork")
        self._results, results = context.Pipe(duplex=False)
        given = self._results, results, read, begin, end
        self._process = context.Process(target=_send, args=given, daemon=True)
        with warnings.catch_warnings(), results:
            # There may be threads that are not Python's, of linear algebra, which bear a fork.
            warnings.simplefilter("ignore", DeprecationWarning)
            self._process.start()

    def __enter__(self) -> _Reader:
        return self

    def __exit__(self, *error: object) -> None:
        self._process.kill()
        self._process.join()
        self._process.close()
        self._results.close()

    def result(self) -> Part | None:
        """What it read, None if it failed or was killed, before sending that or amid it."""
        try:
            part: Part = self._results.recv()
        except (EOFError, OSError):
            return None
        return part


def _send(parents: Connection, results: Connection, read: Read, begin: int, end: int) -> None:
    """Read a part, and send what it holds; of errors, nothing: the parent meets them itself."""
    parents.close()  # or a parent that was killed would leave this process sending to itself for ever
    for number in signals.TERMINATION_SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, signals.TERMINATION_SIGNALS)
    with suppress(Exception):
        results.send(read(begin, end, None))

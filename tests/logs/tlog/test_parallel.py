"""A long log is read by several processes at a time, and gives what one walk over it gives."""

from __future__ import annotations

import errno
import multiprocessing
import os
import signal
import struct
import subprocess
import sys
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import pytest

from flight_replay.logs.tlog import byte_source, parallel, scan
from tests.helpers.log_writer import ENCAPSULATED_DATA, GLOBAL_POSITION_INT, frame, position_payload
from tests.logs.tlog.test_frames import assert_equal_to_slow

POSITION = position_payload(123_456, 47.4, 8.5)
INNER = frame(GLOBAL_POSITION_INT, POSITION, 1)
NEST = frame(ENCAPSULATED_DATA, (b"\1\1" + INNER * 6).ljust(255, b"\7"), 1)


@pytest.fixture
def three_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make short files worth three processes, wherever the tests run and whatever threads others left."""
    active_count, before = threading.active_count, threading.active_count()
    monkeypatch.setattr(threading, "active_count", lambda: active_count() - before + 1)
    monkeypatch.setattr(parallel, "PART_LENGTH", 3_000)
    monkeypatch.setattr(parallel, "_HEAD_START", 100)
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {0, 1, 2})


def read_as_one_walk(data: bytes, path: Path) -> None:
    """Hold what is read of a file against a walk over every byte."""
    path.write_bytes(data)
    with byte_source.opened(path) as opened:
        assert_equal_to_slow(scan.scan(opened)[0], data)
    assert not multiprocessing.active_children()


@pytest.mark.usefixtures("three_parts")
def test_parts_are_joined_where_the_walk_leaves_them(tmp_path: Path) -> None:
    """Frames over the bounds of parts are read once, whatever the bounds fall on."""
    for ahead in range(0, 40, 3):
        read_as_one_walk(b"\0" * ahead + (NEST + INNER) * 32, tmp_path / "made.tlog")


@pytest.mark.usefixtures("three_parts")
def test_a_part_entered_in_the_wrong_place_is_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With nothing to go by before a part, the guess is wrong within a frame, and is found out."""
    monkeypatch.setattr(scan, "_APPROACH", 1)
    for ahead in range(0, 40, 3):
        read_as_one_walk(b"\0" * ahead + (NEST + INNER) * 32, tmp_path / "made.tlog")


@pytest.mark.usefixtures("three_parts")
def test_a_reader_that_dies_costs_time_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A part whose process was killed is read by this one."""
    own = os.getpid()

    def killed_elsewhere(read: Callable[..., object]) -> Callable[..., object]:
        def part(*given: object) -> object:
            if os.getpid() != own:
                os.kill(os.getpid(), signal.SIGKILL)
            return read(*given)

        return part

    monkeypatch.setattr(scan, "_read", killed_elsewhere(scan._read))
    read_as_one_walk((NEST + INNER) * 32, tmp_path / "made.tlog")


@pytest.mark.usefixtures("three_parts")
def test_nobody_forks_beside_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process with threads reads alone: what they hold would never be let go in a fork."""
    assert parallel._useful_parts(1 << 20) == 3
    assert parallel._useful_parts(5_000) == 1
    over = threading.Event()
    thread = threading.Thread(target=over.wait, args=(10,))
    thread.start()
    try:
        assert parallel._useful_parts(1 << 20) == 1
    finally:
        over.set()
        thread.join()
    monkeypatch.setattr("sys.platform", "darwin")
    assert parallel._useful_parts(1 << 20) == 1


@pytest.mark.usefixtures("three_parts")
def test_an_interrupt_while_reading_leaves_no_process_behind(tmp_path: Path) -> None:
    """Ctrl-C in the middle of a log stops the other readers too."""
    path = tmp_path / "made.tlog"
    path.write_bytes((NEST + INNER) * 32)

    def interrupt(done: int, size: int) -> None:
        raise KeyboardInterrupt

    with byte_source.opened(path) as opened, pytest.raises(KeyboardInterrupt):
        scan.scan(opened, interrupt)
    assert not multiprocessing.active_children()


@pytest.mark.usefixtures("three_parts")
def test_a_system_without_room_for_a_process_costs_time_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What cannot be read at the same time is read one after the other."""

    def no_room() -> int:
        raise BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")

    monkeypatch.setattr(os, "fork", no_room)
    read_as_one_walk((NEST + INNER) * 32, tmp_path / "made.tlog")


@pytest.mark.usefixtures("three_parts")
def test_a_reader_that_dies_while_it_sends_costs_time_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A message of which only the beginning came is none."""

    def send_torn(*given: object) -> None:
        results = next(each for each in given if isinstance(each, Connection) and each.writable)
        os.write(results.fileno(), struct.pack("!i", 1_000) + b"torn")

    monkeypatch.setattr(parallel, "_send", send_torn)
    read_as_one_walk((NEST + INNER) * 32, tmp_path / "made.tlog")


@pytest.mark.usefixtures("three_parts")
def test_a_reader_without_memory_says_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Whatever goes wrong in another process is left to this one to meet and to tell."""
    own, real = os.getpid(), scan._read

    def part(*given: Any) -> parallel.Part:
        if os.getpid() != own:
            raise MemoryError
        return real(*given)

    monkeypatch.setattr(scan, "_read", part)
    read_as_one_walk((NEST + INNER) * 32, tmp_path / "made.tlog")
    assert capfd.readouterr() == ("", "")


@pytest.mark.usefixtures("three_parts")
def test_a_pools_worker_reads_alone(tmp_path: Path) -> None:
    """Processes that may have no children of their own read long logs too."""
    given = (NEST + INNER) * 32, tmp_path / "made.tlog"
    worker = multiprocessing.get_context("fork").Process(target=read_as_one_walk, args=given, daemon=True)
    worker.start()
    worker.join(60)
    assert worker.exitcode == 0
    worker.close()


@pytest.mark.usefixtures("three_parts")
def test_nobody_forks_where_ended_children_are_not_heard_of() -> None:
    """A program that was started with SIGCHLD ignored, as by some supervisors, reads alone."""
    before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        assert parallel._useful_parts(1 << 20) == 1
    finally:
        signal.signal(signal.SIGCHLD, before)
    assert parallel._useful_parts(1 << 20) == 3


@pytest.mark.usefixtures("three_parts")
def test_an_interrupt_while_a_reader_starts_leaves_no_process_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C waits until the new process is known to who has to stop it."""
    path = tmp_path / "made.tlog"
    path.write_bytes((NEST + INNER) * 32)
    start = parallel._Reader.__init__

    def interrupted(*given: Any) -> None:
        start(*given)
        # To this thread: one that another test left would not let it wait.
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(parallel._Reader, "__init__", interrupted)
    with byte_source.opened(path) as opened, pytest.raises(KeyboardInterrupt):
        scan.scan(opened)
    assert not multiprocessing.active_children()


@pytest.mark.usefixtures("three_parts")
def test_progress_is_told_in_the_callers_process_only(tmp_path: Path) -> None:
    """Who asked to be told is not run again in every reader."""
    path, told = tmp_path / "made.tlog", tmp_path / "told"
    path.write_bytes((NEST + INNER) * 32)

    def tell(done: int, size: int) -> None:
        with told.open("a") as file:
            file.write(f"{os.getpid()} {done} {size}\n")

    with byte_source.opened(path) as opened:
        scan.scan(opened, tell)
    size = path.stat().st_size
    assert told.read_text() == f"{os.getpid()} {size} {size}\n"


KILLED = """
import os, signal, sys
from flight_replay.logs.tlog import parallel as parts
parts.PART_LENGTH, parts._HEAD_START = 1, 0
os.sched_getaffinity = lambda pid: {0, 1, 2}
for part in parts.read_parts(30, lambda begin, end, enter: parts.Part(0, 0, 0, bytes(1 << 20))):
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only there are parts read by several processes")
def test_readers_end_when_the_program_is_killed() -> None:
    """What has nobody left to send to ends, and lets go of the terminal."""
    killed = subprocess.run([sys.executable, "-c", KILLED], capture_output=True, timeout=30, check=False)
    assert (killed.returncode, killed.stderr) == (-signal.SIGKILL, b"")

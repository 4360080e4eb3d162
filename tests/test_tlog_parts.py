"""A long log is read by several processes at a time, and gives what one walk over it gives."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from log_writer import ENCAPSULATED_DATA, GLOBAL_POSITION_INT, frame, position_payload
from test_tlog_frames import assert_equal_to_slow

from flight_replay.tlog import parts, scan, source

POSITION = position_payload(123_456, 47.4, 8.5)
INNER = frame(GLOBAL_POSITION_INT, POSITION, 1)
NEST = frame(ENCAPSULATED_DATA, (b"\1\1" + INNER * 6).ljust(255, b"\7"), 1)


@pytest.fixture
def three_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make short files worth three processes, wherever the tests run."""
    monkeypatch.setattr(parts, "PART_LENGTH", 3_000)
    monkeypatch.setattr(parts, "_HEAD_START", 100)
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {0, 1, 2})


def read_as_one_walk(data: bytes, path: Path) -> None:
    """Hold what is read of a file against a walk over every byte."""
    path.write_bytes(data)
    with source.opened(path) as opened:
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
    assert parts._useful_parts(1 << 20) == 3
    assert parts._useful_parts(5_000) == 1
    over = threading.Event()
    thread = threading.Thread(target=over.wait, args=(10,))
    thread.start()
    try:
        assert parts._useful_parts(1 << 20) == 1
    finally:
        over.set()
        thread.join()
    monkeypatch.setattr("sys.platform", "darwin")
    assert parts._useful_parts(1 << 20) == 1


@pytest.mark.usefixtures("three_parts")
def test_an_interrupt_while_reading_leaves_no_process_behind(tmp_path: Path) -> None:
    """Ctrl-C in the middle of a log stops the other readers too."""
    path = tmp_path / "made.tlog"
    path.write_bytes((NEST + INNER) * 32)

    def interrupt(done: int, size: int) -> None:
        raise KeyboardInterrupt

    with source.opened(path) as opened, pytest.raises(KeyboardInterrupt):
        scan.scan(opened, interrupt)
    assert not multiprocessing.active_children()

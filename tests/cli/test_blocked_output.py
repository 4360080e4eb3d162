"""Output that nobody reads: the flight goes on, and Ctrl-C ends the program within ten seconds."""

from __future__ import annotations

import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from flight_replay.simulator.server import launch
from tests.helpers.fault_runs import START
from tests.helpers.paths import SAMPLE
from tests.helpers.streams import full_pipe

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
SPEEDUP = 20.0
STOP_TERMINAL = b"\x13"  # Ctrl-S.
ENDS_WITHIN_S = 10.0


@contextmanager
def replaying(folder: Path, *options: str, **streams: Any) -> Iterator[tuple[subprocess.Popen[bytes], Path]]:
    """A replay on a built-in copter, and the recording that a witness on the copter's other port makes."""
    (folder / "config").mkdir(exist_ok=True)
    with launch.run(START, speedup=SPEEDUP, listen=("tcp:127.0.0.1:0", "tcp:127.0.0.1:0")) as running:
        witness_log = folder / "witness.json"
        witness = subprocess.Popen(
            [sys.executable, "-c", WITNESS, running.addresses[1], str(witness_log)], stdout=subprocess.PIPE
        )
        assert witness.stdout is not None
        witness.stdout.readline()
        process = subprocess.Popen(
            [
                sys.executable, "-m", "flight_replay", "--tlog", str(SAMPLE), "--connect", running.connection,
                "--speedup", str(SPEEDUP), "--takeoff-altitude", "5", *options,
            ],
            cwd=folder, start_new_session=True, **streams,
        )  # fmt: skip
        try:
            yield process, witness_log
        finally:
            process.kill()
            process.wait()
            witness.kill()
            witness.wait()
            witness.stdout.close()


WITNESS = """
import json, sys
from pymavlink import mavutil
link = mavutil.mavlink_connection(sys.argv[1], source_system=254)
print("ready", flush=True)
modes = []
while True:
    beat = link.recv_match(type="HEARTBEAT", blocking=True)
    if beat is None or beat.get_srcSystem() != 1:
        continue
    if not modes or modes[-1] != beat.custom_mode:
        modes.append(beat.custom_mode)
        with open(sys.argv[2], "w") as file:
            json.dump(modes, file)
"""
AUTO, RTL = 3, 6


def wait_for_mode(log: Path, mode: int, limit_s: float) -> None:
    """Wait until the witness has seen a mode."""
    end_s = time.monotonic() + limit_s
    while time.monotonic() < end_s:
        with suppress(FileNotFoundError, ValueError):
            if mode in json.loads(log.read_text()):
                return
        time.sleep(0.05)
    pytest.fail(f"mode {mode} was not seen in {limit_s} s")


def read_until(master: int, pattern: bytes, limit_s: float = 60.0) -> bytes:
    """Read a terminal until it has shown a pattern."""
    shown, end_s = b"", time.monotonic() + limit_s
    while not re.search(pattern, shown):
        assert time.monotonic() < end_s, shown
        if select.select([master], [], [], 0.1)[0]:
            shown += os.read(master, 65536)
    return shown


@pytest.mark.parametrize("number", [None, signal.SIGINT, signal.SIGTERM], ids=["to its end", "INT", "TERM"])
def test_a_terminal_that_is_stopped_holds_nothing_up(tmp_path: Path, number: int | None) -> None:
    """After Ctrl-S the flight still ends in RTL, and a signal ends the program in time."""
    master, slave = pty.openpty()
    try:
        with replaying(
            tmp_path, "--duration", "100", stdin=slave, stdout=slave, stderr=slave,
            env={**os.environ, "TERM": "xterm"},
        ) as (process, witness):  # fmt: skip
            read_until(master, rb"Connect")
            wait_for_mode(witness, AUTO, 90)
            os.write(master, STOP_TERMINAL)
            if number is None:
                wait_for_mode(witness, RTL, 60)
                return
            time.sleep(0.5)  # The display is redrawn eight times a second: it is stuck now.
            began_s = time.monotonic()
            process.send_signal(number)
            assert process.wait(30) == 130
            assert time.monotonic() - began_s < ENDS_WITHIN_S
            wait_for_mode(witness, RTL, 5)
    finally:
        os.close(master)
        os.close(slave)


@pytest.mark.parametrize("number", [None, signal.SIGINT], ids=["to its end", "INT"])
def test_a_pipe_that_nobody_reads_holds_nothing_up(tmp_path: Path, number: int | None) -> None:
    """A full pipe, as to a pager that is paused."""
    with (
        full_pipe() as writer,
        replaying(tmp_path, "--duration", "100", "-v", stdout=writer, stderr=writer) as (process, witness),
    ):
        wait_for_mode(witness, AUTO, 90)
        if number is None:
            wait_for_mode(witness, RTL, 60)
            return
        began_s = time.monotonic()
        process.send_signal(number)
        assert process.wait(30) == 130
        assert time.monotonic() - began_s < ENDS_WITHIN_S
        wait_for_mode(witness, RTL, 5)


STUCK_AT_EXIT = """
import os, sys, threading
from flight_replay import __main__
from flight_replay.cli import main
from flight_replay.writing.background import Background
def replay():
    if sys.argv[2] == "stuck":
        Background("test", 1).submit(threading.Event().wait)
    return int(sys.argv[1])
class Late:
    def flush(self):
        os._exit(99)
main.main, sys.stderr = replay, Late()
sys.exit(__main__.main())
"""


@pytest.mark.parametrize(
    ("status", "thread", "exits"), [(130, "ended", 130), (1, "stuck", 1), (1, "ended", 99)]
)
def test_at_the_exit_nothing_is_flushed_that_a_thread_may_hold(status: int, thread: str, exits: int) -> None:
    """A flush would wait for a thread that is stuck; where none is, stderr is flushed."""
    command = [sys.executable, "-c", STUCK_AT_EXIT, str(status), thread]
    assert subprocess.run(command, check=False, timeout=60).returncode == exits


def test_a_recording_that_is_stuck_holds_nothing_up(tmp_path: Path) -> None:
    """A named pipe without a reader: the flight ends as asked, and the error names the recording."""
    os.mkfifo(tmp_path / "pipe.tlog")
    with replaying(
        tmp_path, "--duration", "20", "--record", "pipe.tlog", stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as (process, witness):
        _, errors = process.communicate(timeout=120)
        assert process.returncode == 1
        assert "recording pipe.tlog is incomplete" in errors.decode()
        wait_for_mode(witness, RTL, 1)


def test_a_recording_that_is_stuck_does_not_hold_up_ctrl_c(tmp_path: Path) -> None:
    """RTL is commanded, and the program ends in time."""
    os.mkfifo(tmp_path / "pipe.tlog")
    with replaying(tmp_path, "--record", "pipe.tlog", stderr=subprocess.DEVNULL) as (process, witness):
        wait_for_mode(witness, AUTO, 90)
        began_s = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 130
        assert time.monotonic() - began_s < ENDS_WITHIN_S
        wait_for_mode(witness, RTL, 5)

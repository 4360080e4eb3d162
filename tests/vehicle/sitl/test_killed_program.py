"""SITL and its folder are gone after the program was killed, which then can remove nothing itself."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.vehicle.sitl.test_sitl import BASE_PORT, HELP, stand_in

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are looked for in /proc")

GONE_WITHIN_S = 10.0
PROGRAM = """
import sys, time
from pathlib import Path
from flight_replay.simulator.autopilot.location import Start
from flight_replay.vehicle.sitl import process
from flight_replay.vehicle.sitl.locate import SitlBinary
process._BASE_PORT = int(sys.argv[2])
print("begins", flush=True)
with process.run(SitlBinary(Path(sys.argv[1])), Start(47.5, 8.25, 400.0, 90.0)) as running:
    print("runs", flush=True)
    time.sleep(60)
"""
STUBBORN = """
import signal
for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
    signal.signal(number, signal.SIG_IGN)
if os.fork() == 0:
    time.sleep(60)
print('Waiting for connection ....', flush=True)
time.sleep(60)
"""


def running_in(folder: Path) -> list[int]:
    """Processes whose current folder is inside ``folder``, or was."""
    found = []
    for link in Path("/proc").glob("[0-9]*/cwd"):
        try:
            if str(link.readlink()).startswith(str(folder)):
                found.append(int(link.parent.name))
        except OSError:
            continue
    return found


def started(tmp_path: Path, word: str) -> tuple[subprocess.Popen[bytes], Path]:
    """A program that runs a stand-in, once it has said ``word``, and its folder for temporary files."""
    scratch = tmp_path / "scratch"
    scratch.mkdir(exist_ok=True)
    binary = stand_in(tmp_path, STUBBORN, options=HELP)
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(binary), str(BASE_PORT)],
        stdout=subprocess.PIPE,
        env={**os.environ, "TMPDIR": str(scratch)},
        start_new_session=True,
    )
    assert process.stdout is not None
    for line in process.stdout:
        if word in line.decode():
            break
    return process, scratch


def killed(process: subprocess.Popen[bytes], *, group: bool = False) -> None:
    """End a program as the system does when memory is short."""
    (os.killpg if group else os.kill)(process.pid, signal.SIGKILL)
    process.wait()
    assert process.stdout is not None
    process.stdout.close()


def assert_gone(scratch: Path) -> None:
    """Neither folder nor process is left, and none comes back.

    A file may be: Python's own :mod:`tempfile` writes one and removes it, to see whether it can.
    """
    end_s = time.monotonic() + GONE_WITHIN_S
    while (left := [path for path in scratch.iterdir() if path.is_dir()]) or running_in(scratch):
        assert time.monotonic() < end_s, (left, running_in(scratch))
        time.sleep(0.02)


@pytest.mark.parametrize("group", [False, True], ids=["program", "process group"])
def test_a_killed_program_leaves_no_simulator(tmp_path: Path, group: bool) -> None:
    """Not even one that ignores SIGTERM and has a child."""
    process, scratch = started(tmp_path, "runs")
    assert len(running_in(scratch)) == 2
    killed(process, group=group)
    assert_gone(scratch)


@pytest.mark.slow
@pytest.mark.realtime
def test_a_program_that_is_killed_while_sitl_starts_leaves_nothing(tmp_path: Path) -> None:
    """At twenty moments of the start, from ``--help`` to the simulator that waits."""
    moments = random.Random(14)
    for _ in range(20):
        process, scratch = started(tmp_path, "begins")
        time.sleep(moments.uniform(0.0, 0.6))
        killed(process)
        assert_gone(scratch)

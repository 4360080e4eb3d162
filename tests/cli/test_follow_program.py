"""The program in ``--mode guided``: signals, a stall of the whole process, and output that is stuck."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from flight_replay import vehicle
from flight_replay.flight_modes import CopterMode
from flight_replay.simulator.server import launch
from flight_replay.supervisor.vehicle_interface import Heartbeat
from flight_replay.vehicle.following import TARGET_TIMEOUT_S
from tests.helpers.fault_link import FOREVER_S, FaultLink, fault_link
from tests.helpers.fault_runs import START
from tests.helpers.follow_runs import is_in_mode, is_target
from tests.helpers.paths import SAMPLE

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(sys.platform == "win32", reason="Windows has other signals"),
]
ENDS_WITHIN_S, TARGETS_PER_S = 10.0, 10.0
MOVING_S = ("--from", "60")
"""Where the sample flight is in motion."""


@dataclass
class Program:
    """A program that follows the sample flight on the built-in copter."""

    process: subprocess.Popen[str]
    link: FaultLink
    copter: int
    output: str = ""

    def wait_for(self, pattern: str) -> None:
        """Read until a line has the pattern."""
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.output += line
            if re.search(pattern, line):
                return
        pytest.fail(self.output)

    def end(self) -> tuple[int, str]:
        """Exit status and what was written to stdout."""
        assert self.process.stdout is not None
        assert self.process.stderr is not None
        self.output += self.process.stderr.read()
        written = self.process.stdout.read()
        return self.process.wait(60), written


@contextmanager
def program(
    folder: Path, *options: str, speedup: float = 10.0, stderr: int = subprocess.PIPE
) -> Iterator[Program]:
    with launch.run(START, speedup=speedup) as running, fault_link(running.connection) as link:
        process = subprocess.Popen(
            command(link.connection, *options), stdout=subprocess.PIPE, stderr=stderr, text=True, cwd=folder,
        )  # fmt: skip
        with process:
            try:
                yield Program(process, link, running.process_id)
            finally:
                process.kill()


def command(connection: str, *options: str) -> list[str]:
    """The command line that follows forty seconds of the sample flight."""
    return [
        sys.executable, "-u", "-m", "flight_replay", "--tlog", str(SAMPLE), "--mode", "guided", "--json",
        "--takeoff-altitude", "10", "--altitude", "12", "--connect", connection, "--duration", "40",
        *MOVING_S, *options,
    ]  # fmt: skip


FOLLOWS = r"^ [1-3]\d of 40 s"


def target_timeout_s(link: FaultLink) -> float:
    with vehicle.connect(link.connection) as connected:
        return connected.parameters(["GUID_TIMEOUT"])["GUID_TIMEOUT"]


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["INT", "TERM"])
@pytest.mark.parametrize("moment", [FOLLOWS, "Flying to where"], ids=["following", "approach"])
def test_a_signal_returns_the_vehicle_and_puts_its_parameter_back(
    tmp_path: Path, number: int, moment: str
) -> None:
    with program(tmp_path) as run:
        run.wait_for(moment)
        began_s = time.monotonic()
        run.process.send_signal(number)
        status, _ = run.end()
        assert time.monotonic() - began_s < ENDS_WITHIN_S
        assert status == 130, run.output
        assert run.output.rstrip().endswith("flight-replay: error: interrupted")
        assert "The vehicle confirmed RTL" in run.output
        assert "Traceback" not in run.output
        assert target_timeout_s(run.link) == 3.0


def land(link: FaultLink) -> None:
    """Land and disarm the vehicle, in haste."""
    with vehicle.connect(link.connection) as connected:
        connected.set_speedup(20.0)
        connected.request_mode("LAND")
        heartbeats: list[object] = []
        while Heartbeat("LAND", False) not in heartbeats:
            heartbeats += connected.reports(1.0)


@pytest.mark.slow
def test_a_program_that_is_killed_leaves_a_file_that_the_next_one_tells_of(tmp_path: Path) -> None:
    """Nothing can put the parameter back then; the command that does, once it has landed, is shown."""
    with program(tmp_path) as run:
        run.wait_for(FOLLOWS)
        run.process.kill()
        run.process.wait()
        assert target_timeout_s(run.link) == TARGET_TIMEOUT_S
        again = subprocess.run(
            command(run.link.connection, "--dry-run"),
            capture_output=True,
            text=True,
            cwd=tmp_path,
            check=True,
        )
        told = re.search(rf"GUID_TIMEOUT {TARGET_TIMEOUT_S:g} instead of 3.*run: python (.*)", again.stderr)
        assert told is not None
        restore = [sys.executable, *shlex.split(told[1])]
        assert subprocess.run(restore, cwd=tmp_path, check=False).returncode == 1
        assert target_timeout_s(run.link) == TARGET_TIMEOUT_S
        land(run.link)
        subprocess.run(restore, cwd=tmp_path, check=True)
        assert target_timeout_s(run.link) == 3.0


@pytest.mark.slow
def test_a_signal_ends_the_program_in_time_without_a_link(tmp_path: Path) -> None:
    with program(tmp_path) as run:
        run.wait_for(FOLLOWS)
        run.link.cut(FOREVER_S)
        time.sleep(0.5)
        began_s = time.monotonic()
        run.process.send_signal(signal.SIGINT)
        status, _ = run.end()
        assert time.monotonic() - began_s < ENDS_WITHIN_S
        assert status == 130


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speedup", "stall_s", "off_m"), [(1.0, 1.0, 1.5), (1.0, 3.0, 5.0), (10.0, 1.0, 15.0), (20.0, 3.0, 15.0)]
)
def test_a_stall_of_the_whole_process_is_made_good(
    tmp_path: Path, speedup: float, stall_s: float, off_m: float
) -> None:
    """As when a laptop is busy, or suspended; what arrived meanwhile is old when it is read.

    In haste nobody knows where the flight is stopped: beside the path it is by what braking from 9 m/s takes,
    and on a busy machine it may end there, in RTL.
    """
    with program(tmp_path, speedup=speedup) as run:
        run.wait_for(FOLLOWS)
        run.process.send_signal(signal.SIGSTOP)
        time.sleep(stall_s)
        run.process.send_signal(signal.SIGCONT)
        status, written = run.end()
        flight = json.loads(written)["flight"]
        assert status == 0 or (speedup > 1.0 and flight["ended"] == "off course"), run.output
        assert flight["rtl_confirmed"]
        assert flight["path_error_m"]["flown_to_recorded"]["max"] < off_m


@pytest.mark.slow
def test_a_signal_while_the_process_is_stopped_returns_the_vehicle(tmp_path: Path) -> None:
    with program(tmp_path) as run:
        run.wait_for(FOLLOWS)
        run.process.send_signal(signal.SIGSTOP)
        time.sleep(1.0)
        run.process.send_signal(signal.SIGINT)
        run.process.send_signal(signal.SIGCONT)
        status, _ = run.end()
        assert status == 130
        assert "The vehicle confirmed RTL" in run.output


@pytest.mark.slow
def test_a_simulator_that_ends_is_an_error_of_one_line(tmp_path: Path) -> None:
    with program(tmp_path) as run:
        run.wait_for(FOLLOWS)
        os.kill(run.copter, signal.SIGKILL)
        status, written = run.end()
        assert status == 1
        assert "link to the vehicle lost" in run.output.rstrip().splitlines()[-1]
        assert "Traceback" not in run.output
        assert json.loads(written)["flight"]["ended"] == "link lost"


@pytest.mark.slow
def test_a_recording_that_is_stuck_does_not_hold_the_targets_up(tmp_path: Path) -> None:
    """A named pipe without a reader: the flight is as good as a busy machine's, and the error names it."""
    os.mkfifo(tmp_path / "pipe.tlog")
    # At ten times the speed a machine that pauses for a third of a second ends the flight by itself.
    with program(tmp_path, "--record", "pipe.tlog", speedup=4.0) as run:
        status, written = run.end()
        assert status == 1
        assert "recording pipe.tlog is incomplete" in run.output
        flight = json.loads(written)["flight"]
        assert flight["rtl_confirmed"]
        assert flight["position_error_m"]["mean"] < 2.0


@pytest.mark.slow
def test_a_console_that_is_stuck_does_not_hold_the_targets_up(tmp_path: Path) -> None:
    """A full pipe that nobody reads: the flight still is followed, and returns.

    A busy machine sends fewer targets.
    """
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    try:
        while True:
            os.write(writer, b"x" * 4096)
    except BlockingIOError:
        os.set_blocking(writer, True)
    try:
        with program(tmp_path, stderr=writer) as run:
            end_s = time.monotonic() + 60.0
            while not any(is_in_mode(m, CopterMode.RTL) for m in run.link.from_vehicle[-50:]):
                assert time.monotonic() < end_s
                time.sleep(0.1)
            assert sum(map(is_target, run.link.to_vehicle)) > 0.5 * TARGETS_PER_S * 40.0
    finally:
        os.close(reader)
        os.close(writer)

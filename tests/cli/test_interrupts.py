"""Ctrl-C and SIGTERM at any moment: exit status 130 soon, RTL if it is armed, and nothing left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from tests.helpers.paths import SAMPLE

ENDS_WITHIN_S = 10.0
OPTIONS = ["--tlog", str(SAMPLE), "--speedup", "8", "--takeoff-altitude", "10"]

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has other signals")


@pytest.fixture
def scratch(tmp_path: Path) -> Iterator[Path]:
    """A place for scratch folders of its own, which must be empty again."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    yield folder
    assert list(folder.iterdir()) == []


def interrupted(
    options: list[str], moment: str, scratch: Path, number: int = signal.SIGINT, again: Sequence[int] = ()
) -> tuple[int, str]:
    """Status and words of a run that gets a signal once it has said ``moment``, and then those ``again``."""
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "flight_replay", *OPTIONS, *options],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=scratch.parent,
        env={**os.environ, "TMPDIR": str(scratch)},
    )  # fmt: skip
    assert process.stdout is not None
    said = ""
    with process.stdout:
        for line in process.stdout:
            said += line
            if moment in line:
                break
        process.send_signal(number)
        began_s = time.monotonic()
        for another in again:
            time.sleep(0.02)
            process.send_signal(another)
        said += process.stdout.read()
    status = process.wait(30)
    assert time.monotonic() - began_s < ENDS_WITHIN_S
    return status, said


def children_of_nobody(name: str) -> list[str]:
    """Processes of that name that still run."""
    listed = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True)
    return [line for line in listed.stdout.splitlines() if name in line]


MOMENTS = {
    "connecting": ("Connecting to vehicle", False),
    "uploading": ("Uploading", False),
    "prearm": ("Arm and Takeoff", False),
    "climbing": ("Altitude: ", True),
    "AUTO": ("Distance to waypoint", True),
    "returning": ("Return to launch", True),
}


@pytest.mark.slow
@pytest.mark.parametrize(("moment", "armed"), MOMENTS.values(), ids=MOMENTS.keys())
def test_ctrl_c_at_any_moment(moment: str, armed: bool, scratch: Path) -> None:
    """130 within 10 s; once armed, RTL is commanded and its confirmation told."""
    status, said = interrupted(["--sim", "builtin", "--duration", "6"], moment, scratch)
    assert status == 130
    assert said.rstrip().endswith("flight-replay: error: interrupted")
    assert ("The vehicle confirmed RTL" in said) is armed
    assert "Traceback" not in said


def test_more_signals_do_not_hinder_the_way_home(scratch: Path) -> None:
    """Ctrl-C three times, or a terminal that sends SIGHUP and SIGTERM: home first all the same."""
    again = [signal.SIGINT, signal.SIGHUP, signal.SIGTERM]
    status, said = interrupted(["--sim", "builtin"], "Starting mission", scratch, signal.SIGINT, again)
    assert status == 130
    assert "The vehicle confirmed RTL" in said
    assert "Traceback" not in said


def test_a_signal_that_was_to_be_ignored_still_is(scratch: Path) -> None:
    """``nohup flight-replay`` flies on when its terminal is closed."""
    options = ["--sim", "builtin", "--duration", "2"]
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        status, said = interrupted(options, "Starting mission", scratch, signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)
    assert status == 0
    assert "Completed..." in said


def test_sigterm_sends_the_vehicle_home_too(scratch: Path) -> None:
    """As Ctrl-C does: RTL first."""
    status, said = interrupted(["--sim", "builtin"], "Starting mission", scratch, signal.SIGTERM)
    assert status == 130
    assert "The vehicle confirmed RTL" in said


@pytest.mark.sitl
@pytest.mark.skipif("SITL_BINARY" not in os.environ, reason="SITL_BINARY names no ArduCopter")
@pytest.mark.parametrize(("moment", "armed"), MOMENTS.values(), ids=MOMENTS.keys())
def test_ctrl_c_leaves_no_simulator(moment: str, armed: bool, scratch: Path) -> None:
    """ArduPilot's simulator and its scratch folder are gone, whenever the program is interrupted."""
    status, said = interrupted(["--sim", "sitl", "--duration", "20"], moment, scratch)
    assert status == 130
    assert ("The vehicle confirmed RTL" in said) is armed
    assert children_of_nobody(str(scratch)) == []


@pytest.mark.parametrize("closed", [">&-", "<&- >&- 2>&-"], ids=["stdout", "all"])
def test_a_program_without_standard_streams_works(closed: str, scratch: Path) -> None:
    """A daemon may start it with them closed; the plan is written all the same."""
    plan = scratch.parent / "plan.waypoints"
    line = f'exec "$@" {closed}'
    command = [sys.executable, "-m", "flight_replay", "--tlog", str(SAMPLE), "--dry-run", "--save", str(plan)]
    done = subprocess.run(["sh", "-c", line, "sh", *command], cwd=scratch.parent, check=False, timeout=60)
    assert done.returncode == 0
    assert plan.is_file()

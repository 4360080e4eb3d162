"""Ctrl-C and SIGTERM at any moment: exit status 130 in time, RTL if armed, and nothing is left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from tests.helpers.paths import SAMPLE
from tests.helpers.streams import full_pipe
from tests.output.live_map.test_server import FLOOD

EXIT_TIMEOUT_S = 10.0
DRAWING_S = 60.0
"""A plot and a report take longer on a busy machine; the vehicle does not wait for them."""
OPTIONS = ["--tlog", str(SAMPLE), "--speedup", "8", "--takeoff-altitude", "10"]

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has other signals")


@pytest.fixture
def scratch(tmp_path: Path) -> Iterator[Path]:
    """A folder for temporary files, which must be empty afterwards."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    yield folder
    assert list(folder.iterdir()) == []


def interrupted(
    options: list[str],
    moment: str,
    scratch: Path,
    number: int = signal.SIGINT,
    *,
    again: Sequence[int] = (),
    within_s: float = EXIT_TIMEOUT_S,
) -> tuple[int, str]:
    """Status and output of a run that gets a signal at the line ``moment``, and then those of ``again``."""
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "flight_replay", *OPTIONS, *options],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=scratch.parent,
        env={**os.environ, "TMPDIR": str(scratch)},
    )  # fmt: skip
    assert process.stdout is not None
    output = ""
    with process.stdout:
        for line in process.stdout:
            output += line
            if moment in line:
                break
        process.send_signal(number)
        began_s = time.monotonic()
        for another in again:
            time.sleep(0.02)
            process.send_signal(another)
        output += process.stdout.read()
    status = process.wait(120)
    assert time.monotonic() - began_s < within_s
    return status, output


def processes_with(name: str) -> list[str]:
    """Command lines of running processes that contain ``name``."""
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
FILES = {"--save": ".kml", "--plot": ".png", "--report": ".html"}


@pytest.mark.slow
@pytest.mark.realtime
@pytest.mark.parametrize(("moment", "armed"), MOMENTS.values(), ids=MOMENTS.keys())
def test_ctrl_c_at_any_moment(moment: str, armed: bool, scratch: Path) -> None:
    """The exit status is 130 within 10 s; if armed, RTL is commanded and confirmed."""
    status, output = interrupted(["--sim", "builtin", "--duration", "6"], moment, scratch)
    assert status == 130
    assert output.rstrip().endswith("flight-replay: error: interrupted")
    assert ("The vehicle confirmed RTL" in output) is armed
    assert "Traceback" not in output


def test_further_signals_do_not_prevent_rtl(scratch: Path) -> None:
    """Neither Ctrl-C again, nor a terminal that sends SIGHUP and SIGTERM."""
    again = [signal.SIGINT, signal.SIGHUP, signal.SIGTERM]
    status, output = interrupted(["--sim", "builtin"], "Starting mission", scratch, again=again)
    assert status == 130
    assert "The vehicle confirmed RTL" in output
    assert "Traceback" not in output


def test_what_was_flown_is_saved(scratch: Path) -> None:
    """The plot, the report and the flown track, once RTL is confirmed; the report tells of the interrupt."""
    files = {option: scratch.parent / f"flown{suffix}" for option, suffix in FILES.items()}
    options = ["--sim", "builtin", *(word for each in files.items() for word in map(str, each))]
    status, output = interrupted(options, "Distance to waypoint (2)", scratch, within_s=DRAWING_S)
    assert status == 130
    assert output.index("The vehicle confirmed RTL") < output.index("error: interrupted")
    assert "<name>Flown" in files["--save"].read_text()
    assert files["--plot"].read_bytes().startswith(b"\x89PNG")
    assert "The flight did not end as planned: interrupted." in files["--report"].read_text()


@pytest.mark.slow
@pytest.mark.realtime
def test_a_flood_of_the_live_map_does_not_hold_up_the_way_home(scratch: Path) -> None:
    """RTL is confirmed and the program exits in time, while its page is requested without a pause."""
    process = subprocess.Popen(
        [sys.executable, "-u", "-m", "flight_replay", *OPTIONS, "--sim", "builtin", "--map"],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=scratch.parent,
        env={**os.environ, "TMPDIR": str(scratch)},
    )  # fmt: skip
    assert process.stdout is not None
    output, floods = "", []
    with process.stdout:
        for line in process.stdout:
            output += line
            if line.startswith("Live map: "):
                url = urlsplit(line.split()[2])
                command = [sys.executable, "-c", FLOOD, str(url.port), url.path]
                floods.append(subprocess.Popen(command, stdout=subprocess.DEVNULL))
            if "Distance to waypoint" in line:
                break
        process.send_signal(signal.SIGINT)
        began_s = time.monotonic()
        output += process.stdout.read()
    status = process.wait(30)
    took_s = time.monotonic() - began_s
    for flood in floods:
        flood.kill()
        flood.wait()
    assert (status, len(floods)) == (130, 1)
    assert "The vehicle confirmed RTL" in output
    assert "Traceback" not in output
    assert took_s < EXIT_TIMEOUT_S


def test_an_ignored_signal_stays_ignored(scratch: Path) -> None:
    """``nohup flight-replay`` goes on when its terminal is closed."""
    options = ["--sim", "builtin", "--duration", "2"]
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        status, output = interrupted(options, "Starting mission", scratch, signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)
    assert status == 0
    assert "Completed..." in output


@pytest.mark.parametrize("name", ["SIGTERM", "SIGQUIT", "SIGTSTP"])
def test_other_signals_command_rtl(name: str, scratch: Path) -> None:
    """What other keys of a terminal send does what Ctrl-C does, and so does SIGTERM."""
    number = getattr(signal, name)
    status, output = interrupted(["--sim", "builtin"], "Starting mission", scratch, number)
    assert status == 130
    assert "The vehicle confirmed RTL" in output


@pytest.mark.sitl
@pytest.mark.skipif("SITL_BINARY" not in os.environ, reason="SITL_BINARY names no ArduCopter")
@pytest.mark.parametrize(("moment", "armed"), MOMENTS.values(), ids=MOMENTS.keys())
def test_ctrl_c_leaves_no_simulator(moment: str, armed: bool, scratch: Path) -> None:
    """SITL and its temporary folder are removed at every moment."""
    status, output = interrupted(["--sim", "sitl", "--duration", "20"], moment, scratch)
    assert status == 130, output
    assert ("The vehicle confirmed RTL" in output) is armed
    assert processes_with(str(scratch)) == []


def shadowed(folder: Path, module: str, code: str, *options: str) -> subprocess.CompletedProcess[str]:
    """The outcome of a run that imports ``code`` in the place of a module."""
    (folder / f"{module}.py").write_text(code)
    before = os.environ.get("PYTHONPATH", "")
    return subprocess.run(
        [sys.executable, "-m", "flight_replay", *options], capture_output=True, text=True, check=False,
        timeout=60, env={**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{before}"},
    )  # fmt: skip


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"])
@pytest.mark.parametrize("module", ["argparse", "numpy"])
def test_a_signal_during_the_imports_is_one_line(tmp_path: Path, module: str, number: str) -> None:
    """Status 130, and no traceback of what was being imported."""
    code = f"import os, signal, time\nos.kill(os.getpid(), signal.{number})\ntime.sleep(20)\n"
    done = shadowed(tmp_path, module, code, "--dry-run")
    assert (done.returncode, done.stderr) == (130, "flight-replay: error: interrupted\n")


def test_a_signal_during_the_imports_ends_at_once_whatever_stderr_does(tmp_path: Path) -> None:
    """A pipe that is full gets no line."""
    (tmp_path / "numpy.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n")
    path = f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    command = [sys.executable, "-m", "flight_replay", "--dry-run"]
    with (
        full_pipe() as stderr,
        subprocess.Popen(command, stderr=stderr, env={**os.environ, "PYTHONPATH": path}) as process,
    ):
        try:
            assert process.wait(EXIT_TIMEOUT_S) == 130
        finally:
            process.kill()


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT"])
def test_a_signal_while_the_interpreter_exits_changes_nothing(tmp_path: Path, number: str) -> None:
    """All is done by then, and stays a success."""
    code = f"""
import os, signal, sys
class AtExit:
    def __del__(self, kill=os.kill, me=os.getpid(), number=signal.{number}):
        kill(me, number)
sys.at_exit = AtExit()
"""
    done = shadowed(tmp_path, "sitecustomize", code, "--version")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("closed", [">&-", "<&- >&- 2>&-"], ids=["stdout", "all"])
def test_a_program_without_standard_streams_works(closed: str, scratch: Path) -> None:
    """A daemon may start it with them closed; the mission is saved."""
    plan = scratch.parent / "plan.waypoints"
    line = f'exec "$@" {closed}'
    command = [sys.executable, "-m", "flight_replay", "--tlog", str(SAMPLE), "--dry-run", "--save", str(plan)]
    done = subprocess.run(["sh", "-c", line, "sh", *command], cwd=scratch.parent, check=False, timeout=60)
    assert done.returncode == 0
    assert plan.is_file()

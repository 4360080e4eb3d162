"""ArduPilot SITL: found, started, stopped, and removed on every way out."""

from __future__ import annotations

import os
import socket
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from flight_replay.events import Event, Notice
from flight_replay.exceptions import SimulatorError
from flight_replay.simulator.autopilot.location import Start
from flight_replay.vehicle.sitl import choose, process, simulator, watcher
from flight_replay.vehicle.sitl.bench_parameters import bench_text
from flight_replay.vehicle.sitl.download import DownloadSource
from flight_replay.vehicle.sitl.locate import SitlBinary, find_binary

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the stand-in binaries are scripts")

BASE_PORT = 10_000 + 20 * (os.getpid() % 1000)
"""Instead of 5760, so that tests and simulators that run at the same time do not take each other's ports."""
START = Start(47.5, 8.25, 400.0, 90.0)
HELP = "--home --model --speedup --defaults -I"
WAITS = "print('Waiting for connection ....', flush=True); time.sleep(60)"
OLD = """
from flight_replay.simulator.server.cli import main
port = BASE_PORT + 10 * int(sys.argv[-1].removeprefix("-I"))
print("Waiting for connection ....", open("runs", "a").write("x"), flush=True)
main(["--listen", f"tcp:127.0.0.1:{port}", "--home", "47.5,8.25,400,90", "--speedup", "20"])
"""


@pytest.fixture(autouse=True)
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder for temporary folders, which must be empty again after each test."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.setattr(process, "_BASE_PORT", BASE_PORT)
    yield folder
    assert list(folder.iterdir()) == []


def stand_in(folder: Path, body: str = WAITS, *, options: str = HELP, name: str = "arducopter") -> Path:
    """A script that prints options for --help, and otherwise runs ``body``."""
    path = folder / name
    path.write_text(
        f"#!{sys.executable}\nimport sys, time, os\nBASE_PORT = {BASE_PORT}\n"
        f"if '--help' in sys.argv:\n    print({options!r})\n    sys.exit(0)\n{body}\n"
    )
    path.chmod(0o755)
    return path


def test_it_runs_as_long_as_the_context_lasts(tmp_path: Path) -> None:
    """With the home, heading, speedup and parameters asked for, on free ports."""
    path = stand_in(
        tmp_path, "print(' '.join(sys.argv[1:])); print(os.path.getsize('bench.parm'), flush=True)\n" + WAITS
    )
    with process.run(SitlBinary(path), START, speedup=5.0) as running:
        words = running.log.read_text()
        assert "--model + --home=47.50000000,8.25000000,400.000,90.00 --defaults" in words
        assert words.split("bench.parm")[1].startswith(" --speedup 5 -I")
        assert str(len(bench_text())) in words
        assert running.connection == f"tcp:127.0.0.1:{running.port}"
        assert running.process.poll() is None
    assert running.process.poll() is not None


def test_ports_in_use_are_skipped(tmp_path: Path) -> None:
    """A second simulator takes the next ports."""
    path = stand_in(tmp_path)
    with (
        process.run(SitlBinary(path), START) as first,
        socket.create_server(("127.0.0.1", first.port)),
        process.run(SitlBinary(path), START) as second,
    ):
        assert second.port > first.port
        assert (second.port - first.port) % 10 == 0


def test_a_simulator_that_loses_its_ports_is_started_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of two simulators that start at once the slower one ends, and starts again on the next ports."""
    body = """
port = BASE_PORT + 10 * int(sys.argv[-1].removeprefix("-I"))
import socket
try:
    held = socket.create_server(("127.0.0.1", port))
except OSError:
    sys.exit("bind failed")
"""
    path = stand_in(tmp_path, body + WAITS)
    free = process._free_instance()
    with socket.create_server(("127.0.0.1", process._first_port(free))):
        choices = [free, process._free_instance()]
        monkeypatch.setattr(process, "_free_instance", lambda: choices.pop(0))
        with process.run(SitlBinary(path), START) as running:
            assert running.port > process._first_port(free)
    assert choices == []


def test_named_parameters_replace_the_built_in_ones(tmp_path: Path) -> None:
    """SITL_DEFAULTS_FILEPATH goes to the binary, as a path that does not depend on where it runs."""
    named = tmp_path / "mine.parm"
    named.write_text("FRAME_CLASS 1\n")
    path = stand_in(tmp_path, "print(' '.join(sys.argv[1:]), flush=True)\n" + WAITS)
    with process.run(SitlBinary(path, (named, tmp_path / "b.parm")), START) as running:
        assert f"--defaults {named},{tmp_path / 'b.parm'}" in running.log.read_text()


def test_storage_of_an_old_binary_is_used(tmp_path: Path) -> None:
    """dronekit-sitl's 3.3 takes no parameter file, but comes with its storage."""
    (tmp_path / "default_eeprom.bin").write_bytes(b"stored")
    path = stand_in(
        tmp_path, "print(open('eeprom.bin').read(), flush=True)\n" + WAITS, options="--home --model"
    )
    with process.run(SitlBinary(path), START, speedup=5.0) as running:
        assert "stored" in running.log.read_text()


def test_an_old_binary_gets_each_parameter_over_mavlink(tmp_path: Path) -> None:
    """It runs once to store them, of all files that are named, and once more to fly with them."""
    named, more = tmp_path / "mine.parm", tmp_path / "more.parm"
    named.write_text("# comment\nWPNAV_SPEED,700 # slow\nNO_SUCH_NAME 3\n")
    more.write_text("WPNAV_ACCEL 300\n")
    path = stand_in(tmp_path, OLD, options="--home --model")
    with process.run(SitlBinary(path, (named, more)), START) as running:
        assert (running.log.parent / "runs").read_text() == "xx"


def test_an_old_binary_is_not_flown_with_parameters_that_cannot_be_read(tmp_path: Path) -> None:
    """The file is named in the error."""
    named = tmp_path / "mine.parm"
    named.write_text("WPNAV_SPEED fast\n")
    path = stand_in(tmp_path, OLD, options="--home --model")
    with (
        pytest.raises(SimulatorError, match=f"cannot read the parameter file {named}"),
        process.run(SitlBinary(path, (named,)), START),
    ):
        raise AssertionError


FAILING = {
    "dies": (
        "print('no memory'); print('bad luck', file=sys.stderr, flush=True); sys.exit(3)",
        "ended with status 3",
    ),
    "says why": (
        "print('bind failed on port 5760', flush=True); sys.exit(1)",
        "last output: bind failed on port 5760",
    ),
    "says nothing": ("sys.exit(1)", "last output: nothing"),
}


@pytest.mark.parametrize(("body", "words"), FAILING.values(), ids=FAILING.keys())
def test_a_binary_that_ends_at_start_is_an_error(tmp_path: Path, body: str, words: str) -> None:
    """With its status and last output, and nothing left behind."""
    with pytest.raises(SimulatorError, match=words), process.run(SitlBinary(stand_in(tmp_path, body)), START):
        raise AssertionError


def test_a_missing_library_is_an_error(tmp_path: Path) -> None:
    """With the message of the system's loader."""
    path = tmp_path / "arducopter"
    path.write_text("#!/bin/sh\necho 'error while loading shared libraries: libx.so.1' >&2\nexit 127\n")
    path.chmod(0o755)
    with pytest.raises(SimulatorError, match=r"libx\.so\.1"), process.run(SitlBinary(path), START):
        raise AssertionError


def test_a_file_that_is_not_a_program_is_an_error(tmp_path: Path) -> None:
    """A binary for another machine, for example."""
    path = tmp_path / "arducopter"
    path.write_bytes(b"\x7fELF\x00\x00junk")
    path.chmod(0o755)
    with (
        pytest.raises(SimulatorError, match="is it a binary for this machine"),
        process.run(SitlBinary(path), START),
    ):
        raise AssertionError


def test_a_binary_that_is_never_ready_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With its last output; it is stopped, and not started again because it holds its ports."""
    runs = Path(tempfile.gettempdir()) / "runs"

    def monotonic() -> float:
        return 1000.0 if runs.exists() and runs.stat().st_size > 0 else 0.0

    monkeypatch.setattr(process, "time", SimpleNamespace(monotonic=monotonic, sleep=time.sleep))
    body = """
import socket
held = socket.create_server(("127.0.0.1", BASE_PORT + 10 * int(sys.argv[-1].removeprefix("-I"))))
print("thinking", flush=True)
open("../runs", "a").write("x")
time.sleep(60)
"""
    path = stand_in(tmp_path, body)
    with pytest.raises(SimulatorError, match="last output: thinking"), process.run(SitlBinary(path), START):
        raise AssertionError
    assert runs.read_text() == "x"
    runs.unlink()


def test_a_program_that_does_not_end_after_help_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Any other program that was named by mistake."""
    monkeypatch.setattr(process, "_HELP_S", 0.3)
    path = tmp_path / "sleeper"
    path.write_text("#!/bin/sh\nexec sleep 60\n")
    path.chmod(0o755)
    with (
        pytest.raises(SimulatorError, match="does not end after --help"),
        process.run(SitlBinary(path), START),
    ):
        raise AssertionError


def test_a_simulator_that_ignores_sigterm_is_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After a time limit."""
    monkeypatch.setattr(process, "_STOP_S", 0.2)
    body = "import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN)\n" + WAITS
    with process.run(SitlBinary(stand_in(tmp_path, body)), START) as running:
        pass
    assert running.process.returncode == -9


def test_ctrl_c_while_a_simulator_starts_ends_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At once: the watcher, which there is none of here, would too."""
    started: list[process.SitlProcess] = []

    def interrupted(simulator: process.SitlProcess) -> None:
        started.append(simulator)
        raise KeyboardInterrupt

    monkeypatch.setattr(process, "_wait_ready", interrupted)
    monkeypatch.setattr(watcher, "__file__", os.devnull)
    with pytest.raises(KeyboardInterrupt), process.run(SitlBinary(stand_in(tmp_path)), START):
        raise AssertionError
    assert [simulator.process.poll() is not None for simulator in started] == [True]


@pytest.mark.parametrize("error", [RuntimeError("boom"), KeyboardInterrupt()], ids=["error", "Ctrl-C"])
def test_every_way_out_ends_the_simulator(tmp_path: Path, error: BaseException) -> None:
    """An error or Ctrl-C in the context is raised unchanged."""
    with pytest.raises(type(error)), process.run(SitlBinary(stand_in(tmp_path)), START) as running:
        raise error
    assert running.process.poll() is not None


def test_a_simulator_that_ended_explains_an_error(tmp_path: Path) -> None:
    """An error in the context becomes an error of the simulator."""
    body = (
        "print('Waiting for connection', flush=True); time.sleep(0.1); print('division by zero'); sys.exit(8)"
    )
    with (
        pytest.raises(SimulatorError, match=r"status 8; its last output: .*division"),
        process.run(SitlBinary(stand_in(tmp_path, body)), START) as running,
    ):
        running.process.wait(60)
        raise RuntimeError("no heartbeat")


def test_a_simulator_that_ended_in_a_flight_is_told(tmp_path: Path) -> None:
    """The flight up to there is kept; a link that is lost is not all that is said of it."""
    body = "print('Waiting for connection', flush=True); time.sleep(0.1); print('stack smashed'); sys.exit(8)"
    said: list[Event] = []
    with process.run(SitlBinary(stand_in(tmp_path, body)), START, listener=said.append) as running:
        running.process.wait(60)
    (notice,) = said
    assert isinstance(notice, Notice)
    assert notice.warning
    assert "simulator ended before the flight did" in notice.text
    assert "status 8; its last output: Waiting for connection / stack smashed" in notice.text


# Where it is found


def test_a_named_binary_comes_first(tmp_path: Path) -> None:
    """--sitl, then SITL_BINARY, then PATH, then dronekit-sitl's cache, then none."""
    named, other = stand_in(tmp_path, name="one"), stand_in(tmp_path, name="two")
    on_path = stand_in(tmp_path)
    source = DownloadSource("https://nowhere.invalid", tmp_path / "cache", "linux")
    source.folder.mkdir(parents=True)
    cached = stand_in(source.folder, name="apm")
    where = {"SITL_BINARY": str(other), "PATH": str(tmp_path)}
    assert find_binary(named, source, where) == SitlBinary(named, named=True)
    assert find_binary(None, source, where) == SitlBinary(other, named=True)
    assert find_binary(None, source, {"PATH": str(tmp_path)}) == SitlBinary(on_path)
    assert find_binary(None, source, {}) == SitlBinary(cached)
    assert find_binary(None, DownloadSource("", tmp_path / "none", "linux"), {}) is None
    assert find_binary(None, None, {}) is None


def test_files_that_are_named_must_exist(tmp_path: Path) -> None:
    """A missing binary, one that is not executable, and a missing parameter file are named in the error."""
    with pytest.raises(SimulatorError, match="named by --sitl, does not exist"):
        find_binary(tmp_path / "none", None, {})
    with pytest.raises(SimulatorError, match="named by SITL_BINARY, does not exist"):
        find_binary(None, None, {"SITL_BINARY": "/no/such/file"})
    with pytest.raises(SimulatorError, match="named by --sitl, is a folder; name the SITL binary in it"):
        find_binary(tmp_path, None, {})
    plain = tmp_path / "plain"
    plain.write_text("")
    if os.geteuid() != 0 or not os.access(plain, os.X_OK):
        with pytest.raises(SimulatorError, match="chmod"):
            find_binary(plain, None, {})
    with pytest.raises(SimulatorError, match="named by SITL_DEFAULTS_FILEPATH, does not exist"):
        find_binary(None, None, {"SITL_DEFAULTS_FILEPATH": f"{plain},/no/such.parm"})
    other = stand_in(tmp_path, name="other")
    defaults = {"SITL_BINARY": str(stand_in(tmp_path)), "SITL_DEFAULTS_FILEPATH": f"{plain},{other}"}
    binary = find_binary(None, None, defaults)
    assert binary is not None
    assert binary.defaults == (plain, other)


# Which simulator it will be


@pytest.fixture
def no_sitl(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No binary on this machine, and no network."""

    def none() -> DownloadSource:
        return DownloadSource("http://127.0.0.1:9/sitl", tmp_path / "cache", "linux")

    monkeypatch.setattr(choose, "dronekit_sitl_source", none)
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))
    monkeypatch.delenv("SITL_BINARY", raising=False)
    monkeypatch.delenv("SITL_DEFAULTS_FILEPATH", raising=False)


@pytest.mark.usefixtures("no_sitl")
def test_without_ardupilot_the_built_in_copter_flies() -> None:
    """``auto`` falls back and says how to have another; ``sitl`` is an error."""
    said: list[Event] = []
    with simulator("auto", None, START, listener=said.append) as connection:
        assert connection.startswith("tcp:127.0.0.1:")
    assert said == [Notice("Starting copter simulator (built-in copter; --sim sitl downloads ArduPilot's)")]
    said.clear()
    with simulator("builtin", None, START, listener=said.append):
        assert said == [Notice("Starting copter simulator (built-in copter)")]
    with pytest.raises(SimulatorError, match="cannot download"), simulator("sitl", None, START):
        raise AssertionError


@pytest.mark.usefixtures("no_sitl")
def test_only_sitl_asks_the_network(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """``auto`` and ``builtin`` download nothing; ``sitl`` says what and from where before it does."""
    asked: list[object] = []
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(0.2)
        url = f"http://127.0.0.1:{server.getsockname()[1]}/sitl"
        place = DownloadSource(url, tmp_path / "cache", "linux")
        monkeypatch.setattr(choose, "dronekit_sitl_source", lambda: place)
        for kind in ("auto", "builtin"):
            with simulator(kind, None, START), pytest.raises(TimeoutError):
                server.accept()
        server.close()
        with pytest.raises(SimulatorError), simulator("sitl", None, START, listener=asked.append):
            raise AssertionError
    assert asked == [Notice(f"Downloading ArduPilot SITL (ArduCopter 3.3) from {place.url}")]


@pytest.mark.usefixtures("no_sitl")
def test_a_binary_on_path_is_preferred(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If it cannot start the built-in copter flies, unless the binary was named."""
    bin_folder = tmp_path / "empty"
    bin_folder.mkdir()
    stand_in(bin_folder)
    said: list[Event] = []
    with simulator("auto", None, START, listener=said.append) as connection:
        assert int(connection.split(":")[2]) % 10 == 0
    assert said == [Notice("Starting copter simulator (SITL)")]
    stand_in(bin_folder, "sys.exit(1)")
    said.clear()
    with simulator("auto", None, START, listener=said.append):
        starting, why, instead = (each.text for each in said if isinstance(each, Notice))
    assert starting == "Starting copter simulator (SITL)"
    assert "ended with status 1" in why
    assert instead == "Starting copter simulator (built-in copter)"
    monkeypatch.setenv("SITL_BINARY", str(bin_folder / "arducopter"))
    with pytest.raises(SimulatorError, match="ended with status 1"), simulator("auto", None, START):
        raise AssertionError


@pytest.mark.usefixtures("no_sitl")
def test_a_named_path_is_run_or_an_error(tmp_path: Path) -> None:
    """--sitl PATH never falls back."""
    with simulator("sitl", stand_in(tmp_path), START) as connection:
        assert connection.startswith("tcp:")
    with pytest.raises(SimulatorError, match="does not exist"), simulator("sitl", tmp_path / "none", START):
        raise AssertionError

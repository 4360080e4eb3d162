"""The simulator as a process: launched by a program, or by hand as flight-replay-sim."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from flight_replay.exceptions import SimulatorError
from flight_replay.mavlink import robust_parser
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server import child, cli
from flight_replay.simulator.server.endpoint import Endpoint
from flight_replay.simulator.server.launch import run
from flight_replay.simulator.server.settings import Settings, settings_of
from tests.helpers.sim_station import START


def is_running(process_id: int) -> bool:
    """Whether a process is there, and no zombie."""
    try:
        os.kill(process_id, 0)
        if not Path("/proc/self/stat").exists():
            return True
        return Path(f"/proc/{process_id}/stat").read_text(encoding="ascii").split()[2] != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False


def listen(address: str, kind: str, wall_s: float = 60.0) -> object:
    """The first message of a kind from a TCP address."""
    host, port = address.split(":")[1:]
    decoder = robust_parser()
    deadline = time.monotonic() + wall_s
    with socket.create_connection((host, int(port)), wall_s) as sock:
        sock.settimeout(wall_s)
        while time.monotonic() < deadline:
            for message in decoder.parse_buffer(sock.recv(65536)) or []:
                if message.get_type() == kind:
                    return message
    raise AssertionError(f"no {kind}")


def test_a_launched_copter_can_be_reached_and_leaves_nothing() -> None:
    """The connection string is a real port; after the block the process is gone."""
    with run(START, speedup=20) as running:
        assert re.fullmatch(r"tcp:127\.0\.0\.1:[1-9]\d+", running.connection)
        assert listen(running.connection, "HEARTBEAT")
        assert is_running(running.process_id)
    assert not is_running(running.process_id)
    with pytest.raises(OSError, match="refused"):
        listen(running.connection, "HEARTBEAT")


def test_a_launched_copter_has_the_faults_and_parameters_it_was_given() -> None:
    """Both reach the process."""
    faults = Faults(prearm_failure="Barometer not healthy")
    with run(START, speedup=50, parameters={"FENCE_ENABLE": 1}, faults=faults) as running:
        text = listen(running.connection, "STATUSTEXT")
        while "PreArm" not in text.text:  # type: ignore[attr-defined]
            text = listen(running.connection, "STATUSTEXT")
        assert text.text == "PreArm: Barometer not healthy"  # type: ignore[attr-defined]


def test_what_cannot_be_launched_says_why() -> None:
    """Unknown parameters and bad addresses come back as the error they are in the process."""
    with (
        pytest.raises(SimulatorError, match="has no parameter NO_SUCH"),
        run(START, parameters={"NO_SUCH": 1}),
    ):
        pass
    with pytest.raises(SimulatorError, match="is not a valid address"), run(START, listen=["5760"]):
        pass


def test_a_killed_copter_is_no_trouble_at_the_end() -> None:
    """The block ends in peace even if the process died before."""
    with run(START) as running:
        os.kill(running.process_id, signal.SIGKILL)
    assert not is_running(running.process_id)


def test_the_copter_does_not_outlive_the_program_that_launched_it() -> None:
    """Not even one that is killed and can tidy up nothing."""
    program = (
        "import time; from flight_replay.simulator.server.launch import run; "
        "from flight_replay.simulator.autopilot.location import Start\n"
        "with run(Start(0, 1)) as running: print(running.process_id, flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True) as launcher:
        assert launcher.stdout is not None
        copter = int(launcher.stdout.readline())
        assert is_running(copter)
        launcher.kill()
    deadline = time.monotonic() + 60
    while is_running(copter):
        assert time.monotonic() < deadline
        time.sleep(0.02)


@pytest.mark.parametrize("settings", ["", Settings(START).as_line()], ids=["before", "after its settings"])
def test_a_copter_whose_launcher_was_killed_while_it_starts_says_nothing(settings: str) -> None:
    """Nobody reads its addresses; the terminal shows no traceback of it."""
    with subprocess.Popen(
        [sys.executable, "-m", "flight_replay.simulator.server.child"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as copter:  # fmt: skip
        assert copter.stdin and copter.stdout and copter.stderr
        copter.stdout.close()
        copter.stdin.write(settings)
        copter.stdin.close()
        assert copter.stderr.read() == ""
        copter.wait(30)


def test_an_interrupt_while_a_copter_starts_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is not left behind."""
    started: list[subprocess.Popen[str]] = []

    def interrupted(process: subprocess.Popen[str], _: Settings) -> None:
        started.append(process)
        raise KeyboardInterrupt

    monkeypatch.setattr("flight_replay.simulator.server.launch._started", interrupted)
    with pytest.raises(KeyboardInterrupt), run(START):
        raise AssertionError
    assert started[0].poll() is not None


def test_ctrl_c_at_the_terminal_does_not_reach_a_copter() -> None:
    """Its process group is another one, also while it is imported and cannot ignore the signal yet."""
    with run(START) as running:
        assert os.getpgid(running.process_id) != os.getpgid(0)


def test_the_process_ends_with_its_stdin(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In process: settings in, addresses out, and the end when nothing more can be read."""

    class Input:
        def readline(self) -> str:
            return Settings(START).as_line()

        def read(self) -> str:
            return ""

    monkeypatch.setattr(sys, "stdin", Input())
    assert child.main() == 0
    assert '"addresses": ["tcp:127.0.0.1:' in capsys.readouterr().out
    monkeypatch.setattr(Input, "readline", lambda self: Settings(START, ("x",)).as_line())
    assert child.main() == 1
    assert "is not a valid address" in capsys.readouterr().out


def test_settings_travel_as_one_line() -> None:
    """What is sent is what arrives."""
    settings = Settings(START, ("tcp:127.0.0.1:0",), {"RTL_ALT": 1.5}, Faults(takeoff_climbs=False))
    assert settings.as_line().count("\n") == 1
    assert settings_of(settings.as_line()) == settings


@pytest.fixture(autouse=True)
def same_signals() -> Iterator[None]:
    """The handlers of signals as they were."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@contextmanager
def by_hand(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """flight-replay-sim with its output at hand, ended for certain."""
    process = subprocess.Popen(
        [
            sys.executable,
            "-c",
            "import sys; from flight_replay.simulator.server.cli import main; sys.exit(main())",
            *arguments,
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_by_hand_it_runs_until_interrupted(number: signal.Signals, status: int) -> None:
    """It says where it listens, each address on a line, and ends quietly on Ctrl-C and SIGTERM."""
    with by_hand(
        "--listen", "tcp:127.0.0.1:0", "--listen", "udpout:127.0.0.1:9", "--speedup", "20"
    ) as process:
        assert process.stdout is not None
        address = process.stdout.readline().removeprefix("listening on ").strip()
        assert process.stdout.readline() == "sending to udpout:127.0.0.1:9\n"
        assert listen(address, "HEARTBEAT")
        process.send_signal(number)
        assert process.wait(60) == status
        assert process.stderr is not None
        assert process.stderr.read() == ""


def test_interrupted_in_process_it_closes_its_links(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """main() returns 130 on SIGINT, and the port is free again."""
    serve = Endpoint.run

    def interrupted(endpoint: Endpoint, stop: Callable[[], bool]) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        serve(endpoint, stop)

    monkeypatch.setattr(Endpoint, "run", interrupted)
    assert cli.main(["--listen", "tcp:127.0.0.1:0", "--speedup", "50"]) == 130
    port = int(capsys.readouterr().out.split(":")[-1])
    with socket.socket() as again:
        again.bind(("127.0.0.1", port))


def test_a_port_in_use_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    """Status 1 and one sentence, no traceback."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert cli.main(["--listen", f"tcp:127.0.0.1:{port}"]) == 1
    error = capsys.readouterr().err
    assert error.startswith(f"flight-replay-sim: error: cannot listen on tcp:127.0.0.1:{port}: ")
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "start"),
    [
        ("47.5,8.25,500,90", Start(47.5, 8.25, 500.0, 90.0)),
        ("-35,149", Start(-35.0, 149.0, 0.0, 0.0)),
        ("-35,149,10", Start(-35.0, 149.0, 10.0, 0.0)),
    ],
)
def test_home_is_latitude_longitude_altitude_heading(text: str, start: Start) -> None:
    """Altitude and heading may be left out."""
    assert cli.home(text) == start


def test_southern_homes_need_no_equals_sign(monkeypatch: pytest.MonkeyPatch) -> None:
    """--home -35.4,149.2 is a position, though it begins like an option."""
    asked: list[Settings] = []

    def opened(settings: Settings) -> None:
        asked.append(settings)
        raise SimulatorError("enough")

    monkeypatch.setattr("flight_replay.simulator.server.settings.open_endpoint", opened)
    assert cli.main(["--home", "-35.4,149.2,580,10", "--speedup", "5"]) == 1
    assert asked == [Settings(Start(-35.4, 149.2, 580.0, 10.0), (cli.DEFAULT_LISTEN,), {"SIM_SPEEDUP": 5.0})]


@pytest.mark.parametrize(
    "arguments",
    [["--home", "91,0"], ["--home", "0"], ["--home", "a,b"], ["--home", "1,2,3,4,5"], ["--home", "1,2,nan"],
     ["--home", "1,2,1e7"], ["--home", "1,2,-1e9"],
     ["--listen", "5760"], ["--speedup", "0"], ["--speedup", "0.009"], ["--speedup", "fast"],
     ["--speedup", "inf"]],
    ids=" ".join,
)  # fmt: skip
def test_wrong_usage_is_status_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """The offending value is named."""
    with pytest.raises(SystemExit) as caught:
        cli.main(arguments)
    assert caught.value.code == 2
    assert f"'{arguments[1]}'" in capsys.readouterr().err


def test_a_reason_not_to_start_cannot_control_the_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It may quote an address, or a name server."""

    def fail(_: Settings) -> None:
        raise SimulatorError("no \x1b[31m")

    monkeypatch.setattr("flight_replay.simulator.server.settings.open_endpoint", fail)
    assert cli.main([]) == 1
    assert capsys.readouterr().err == "flight-replay-sim: error: no \\x1b[31m\n"


@pytest.mark.parametrize("option", ["--home", "--listen", "--speedup", "--nonsense"])
def test_wrong_usage_cannot_control_the_terminal(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    """What was typed is repeated with escapes."""
    with pytest.raises(SystemExit):
        cli.main([option, "\x1b[31m\u202e"])
    written = capsys.readouterr().err
    assert r"\x1b[31m\u202e" in written.replace("\\\\", "\\")
    assert "\x1b" not in written

"""main.py: exit statuses, the error line, JSON, and whole replays in this process."""

import json
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from flight_replay import signals
from flight_replay.cli import flight_step
from flight_replay.cli.flight_result import FlightResult, ReplayInterrupted
from flight_replay.cli.main import main
from flight_replay.cli.output_step import ReplayResult
from flight_replay.logs.sample import sample_log
from tests.helpers.made_replays import made_replay
from tests.helpers.streams import Terminal

ROUTE_KEYS = {
    "method",
    "points",
    "items",
    "fixes_covered",
    "length_m",
    "planned_error_m",
    "heights",
    "limits",
    "predicted",
    "predicted_duration_s",
}
ERROR_KEYS = {"path_error_m", "position_error_m", "height_error_m", "heading_error_deg"}
pytestmark = pytest.mark.usefixtures("folder")


def run_json(capsys: pytest.CaptureFixture[str], *argv: str) -> Any:
    """The JSON object of a run."""
    assert main([*argv, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_plain_dry_run_plans_the_sample(capsys: pytest.CaptureFixture[str]) -> None:
    """Without flight.tlog in the folder, the sample flight is planned, in the example's wording."""
    assert main(["--dry-run"]) == 0
    out = capsys.readouterr().out
    assert "Generating waypoints from tlog...\n Generated 100 waypoints from tlog\n" in out
    assert "Planned path error" in out


def test_a_log_in_this_folder_comes_before_the_sample(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where no log is named, flight.tlog is read if it exists."""
    (folder / "flight.tlog").write_bytes(sample_log().read_bytes()[:600_000])
    assert run_json(capsys, "--dry-run")["log"]["bytes"] == 600_000


def test_a_flight_that_cannot_be_read_is_not_replaced_by_the_sample(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A link that leads nowhere would have another flight flown."""
    (folder / "flight.tlog").symlink_to("nowhere")
    assert main(["--dry-run"]) == 1
    assert "flight.tlog does not exist; name a recorded flight" in capsys.readouterr().err


def test_json_is_the_contract(capsys: pytest.CaptureFixture[str]) -> None:
    """One object on stdout with the promised keys; flight is null after a dry run."""
    summary = run_json(capsys, "--dry-run")
    assert set(summary) == {"log", "route", "flight"}
    assert summary["flight"] is None
    assert set(summary["log"]) == {
        *("path", "format", "bytes", "firmware", "vehicle_type", "start_utc_s", "timed", "boots", "fixes"),
        *("without_position", "rejected", "rejected_by_reason", "vehicles", "flights", "notes"),
    }
    assert set(summary["route"]) == ROUTE_KEYS
    assert summary["route"]["points"] == len(summary["route"]["items"]) == 100
    first = summary["route"]["items"][0]
    assert (first["seq"], first["command"], first["frame"]) == (1, 16, 3)
    both_ways = summary["route"]["planned_error_m"]
    assert set(both_ways) == {"recorded_to_planned", "planned_to_recorded"}
    assert all(set(error) == {"mean", "p95", "max"} for error in both_ways.values())
    assert set(summary["route"]["predicted"]) == ERROR_KEYS
    assert set(summary["route"]["predicted"]["path_error_m"]) == {"recorded_to_flown", "flown_to_recorded"}


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--tlog", "none.tlog"], "none.tlog"),
        (["--save", "mission.doc", "--dry-run"], ".waypoints"),
        (["--flight", "99", "--dry-run"], "--flight"),
        (["--vehicle", "77", "--dry-run"], "77"),
    ],
)
def test_expected_failures_are_one_line(
    argv: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The exit status is 1, and one line on stderr names what failed."""
    assert main(argv) == 1
    err = capsys.readouterr().err
    assert err.startswith("flight-replay: error: ")
    assert err.count("\n") == 1
    assert message in err


def test_wrong_usage_is_exit_status_2(capsys: pytest.CaptureFixture[str]) -> None:
    """An unknown option is told in one line, with a hint."""
    assert main(["--no-such-thing"]) == 2
    told = "flight-replay: error: unrecognized arguments: --no-such-thing; see flight-replay --help\n"
    assert capsys.readouterr().err == told
    assert main(["--flihgt", "2"]) == 2
    assert capsys.readouterr().err.endswith("; did you mean --flight?\n")
    assert main(["--quiet"]) == 2  # is not like --wait
    assert capsys.readouterr().err.endswith("; see flight-replay --help\n")
    assert main(["my", "flight.tlog"]) == 2
    assert capsys.readouterr().err.endswith(
        "flight.tlog; name one file, in quotes if there are spaces in its name\n"
    )


def test_a_dry_run_tells_what_it_does_not_need(capsys: pytest.CaptureFixture[str]) -> None:
    """Whoever looks before flying adds --dry-run to the command; it goes on, with a word."""
    assert main(["--dry-run", "--land", "--gcs", "udp:127.0.0.1:14551", "-q"]) == 0
    told = "Warning: --land has no effect with --dry-run\nWarning: --gcs has no effect with --dry-run\n"
    assert capsys.readouterr().out == told


def test_a_connection_string_is_checked_before_anything_is_read(capsys: pytest.CaptureFixture[str]) -> None:
    """A typing error is told at once."""
    assert main(["--connect", "tcp:127.0.0.1"]) == 1
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "invalid connection string 'tcp:127.0.0.1'" in shown.err


def test_sample_flies_on_the_built_in_copter(capsys: pytest.CaptureFixture[str]) -> None:
    """From log to RTL: 100 points, 60 s of AUTO by the vehicle's clock, RTL confirmed."""
    flight = run_json(capsys, "--sim", "builtin", "--speedup", "20")["flight"]
    assert flight["simulated"]
    assert flight["auto_s"] == pytest.approx(60, abs=1)
    assert flight["rtl_confirmed"]
    assert flight["ended"] == "duration"
    assert 20 <= flight["waypoints_reached"] <= 24
    assert flight.keys() >= ERROR_KEYS
    assert flight["path_error_m"]["recorded_to_flown"]["mean"] < 0.3
    assert flight["path_error_m"]["flown_to_recorded"]["mean"] < 0.3
    assert flight["height_error_m"]["max"] < 0.5
    assert flight["heading_error_deg"]["max"] <= 180
    assert flight["not_measured"] == {}
    coverage = flight["coverage"]
    assert coverage["to_fly_all"] == ["--route fit", "--duration all"]
    assert 30 < coverage["recorded_s"] < 60 < coverage["of_recorded_s"]


def test_plain_lines_keep_the_example_s_wording(capsys: pytest.CaptureFixture[str]) -> None:
    """The lines of DroneKit's example come in its order."""
    assert main(["--sim", "builtin", "--speedup", "20", "--duration", "5"]) == 0
    out = capsys.readouterr().out
    lines = [
        "Generating waypoints from tlog...",
        " Generated 100 waypoints from tlog",
        "Starting copter simulator (built-in copter)",
        "Connecting to vehicle on: ",
        "Uploading 100 waypoints to vehicle...",
        "Arm and Takeoff",
        " Waiting for vehicle to initialise...",
        " Waiting for arming...",
        " Taking off!",
        " Altitude: ",
        " Reached target altitude of ~30",
        "Starting mission",
        "Distance to waypoint (",
        "Return to launch",
        "Close vehicle object",
        "Completed...",
    ]
    places = [out.find(line) for line in lines]
    assert -1 not in places
    assert places == sorted(places)


def test_a_closed_pipe_is_no_error() -> None:
    """``flight-replay --dry-run --json | head`` ends quietly."""
    program = [sys.executable, "-m", "flight_replay", "--dry-run", "--json"]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout and process.stderr
        process.stdout.close()
        errors = process.stderr.read().decode()
    assert "Error" not in errors
    assert "Exception" not in errors


def test_after_an_interrupt_the_cursor_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """On each terminal: a display that is stuck may have left it hidden."""
    streams = Terminal(), Terminal()
    monkeypatch.setattr(sys, "stdout", streams[0])
    monkeypatch.setattr(sys, "stderr", streams[1])
    monkeypatch.setenv("TERM", "xterm")

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("flight_replay.cli.main.replay", interrupt)
    assert main(["--dry-run", "-q"]) == 130
    assert [stream.getvalue().count("\x1b[?25h") for stream in streams] == [1, 1]


def test_an_error_of_what_an_interrupt_left_half_done_is_the_interrupt(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A condition variable may lose its lock there, and raise a RuntimeError when it is left."""

    def interrupt(*_: object) -> None:
        try:
            raise KeyboardInterrupt
        finally:
            threading.Lock().release()

    monkeypatch.setattr("flight_replay.cli.main.replay", interrupt)
    assert main(["--dry-run", "-q"]) == 130
    assert capsys.readouterr().err == "flight-replay: error: interrupted\n"


def test_while_an_interrupted_flight_is_saved_the_next_signal_ends_the_program(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before that it is ignored, as RTL must be commanded: this is over, and a report takes seconds."""
    route, outcome = made_replay()
    saved: list[FlightResult] = []

    def interrupt(*_: object) -> None:
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        raise ReplayInterrupted(route, FlightResult("Copter", True, outcome))

    def save(_options: object, result: ReplayResult, _track: object) -> list[str]:
        assert result.flight is not None
        saved.append(result.flight)
        signal.raise_signal(signal.SIGINT)
        pytest.fail("the signal is ignored")

    before = [signal.getsignal(each) for each in signals.TERMINATION_SIGNALS]
    monkeypatch.setattr(flight_step, "fly", interrupt)
    monkeypatch.setattr("flight_replay.cli.save_step.save_flown", save)
    try:
        assert main(["-q"]) == 130
    finally:
        for number, handler in zip(signals.TERMINATION_SIGNALS, before, strict=True):
            signal.signal(number, handler)
    assert [each.outcome for each in saved] == [outcome]
    assert capsys.readouterr().err == "flight-replay: error: interrupted\n"

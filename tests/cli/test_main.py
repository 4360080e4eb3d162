"""The command line, in this process: exit statuses, the one error line, JSON, and whole replays."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from flight_replay import __main__ as program
from flight_replay.cli.main import main
from flight_replay.logs.sample import sample_log

ROUTE_KEYS = {
    "method",
    "points",
    "items",
    "fixes_covered",
    "length_m",
    "planned_error_m",
    "predicted_duration_s",
}


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Run in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_json(capsys: pytest.CaptureFixture[str], *argv: str) -> Any:
    """Run with --json; what stdout holds."""
    assert main([*argv, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_plain_dry_run_plans_the_sample(capsys: pytest.CaptureFixture[str]) -> None:
    """Without a log here, the packaged sample flight is planned, in the example's words."""
    assert main(["--dry-run"]) == 0
    out = capsys.readouterr().out
    assert "Generating waypoints from tlog...\n Generated 100 waypoints from tlog\n" in out
    assert "planned error" in out


def test_a_log_in_this_folder_comes_before_the_sample(
    elsewhere: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """flight.tlog here is what a bare call reads."""
    (elsewhere / "flight.tlog").write_bytes(sample_log().read_bytes()[:200_000])
    assert run_json(capsys, "--dry-run")["log"]["bytes"] == 200_000


def test_json_is_the_contract(capsys: pytest.CaptureFixture[str]) -> None:
    """One object on stdout with DESIGN.md's keys, and flight null when nothing was flown."""
    told = run_json(capsys, "--dry-run")
    assert set(told) == {"log", "route", "flight"}
    assert told["flight"] is None
    assert set(told["log"]) == {
        "path",
        "bytes",
        "fixes",
        "without_position",
        "rejected",
        "vehicles",
        "flights",
    }
    assert set(told["route"]) == ROUTE_KEYS
    assert told["route"]["points"] == len(told["route"]["items"]) == 100
    first = told["route"]["items"][0]
    assert (first["seq"], first["command"], first["frame"]) == (1, 16, 3)
    assert set(told["route"]["planned_error_m"]) == {"mean", "p95", "max"}


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["--tlog", "none.tlog"], "none.tlog"),
        (["--save", "mission.doc", "--dry-run"], ".waypoints"),
        (["--plot", "picture.bmp", "--dry-run"], ".png"),
        (["--report", "report.txt", "--dry-run"], ".html"),
        (["--save", "missing/mission.plan", "--dry-run"], "missing"),
        (["--gcs", "carrier pigeon", "--dry-run"], "carrier pigeon"),
        (["--flight", "99", "--dry-run"], "--flight"),
        (["--vehicle", "77", "--dry-run"], "77"),
    ],
)
def test_expected_failures_are_one_line(
    argv: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit status 1, one line on stderr that names the thing, nothing thrown."""
    assert main(argv) == 1
    err = capsys.readouterr().err
    assert err.startswith("flight-replay: error: ")
    assert err.count("\n") == 1
    assert words in err


def test_wrong_usage_is_exit_status_2(capsys: pytest.CaptureFixture[str]) -> None:
    """Options that do not exist are wrong usage."""
    assert main(["--no-such-thing"]) == 2
    assert "usage:" in capsys.readouterr().err


def test_sample_flies_on_the_built_in_copter(capsys: pytest.CaptureFixture[str]) -> None:
    """From log to RTL: 100 points, 60 s of AUTO by the vehicle's clock, RTL confirmed."""
    flight = run_json(capsys, "--sim", "builtin", "--speedup", "20")["flight"]
    assert flight["simulated"]
    assert flight["auto_s"] == pytest.approx(60, abs=1)
    assert flight["rtl_confirmed"]
    assert flight["ended"] == "duration"
    assert 20 <= flight["waypoints_reached"] <= 24
    assert flight["distance_in_space_m"]["mean"] < 0.3


def test_plain_lines_keep_the_example_s_wording(capsys: pytest.CaptureFixture[str]) -> None:
    """The lines of DroneKit's example come in its order."""
    assert main(["--sim", "builtin", "--speedup", "20", "--duration", "5"]) == 0
    out = capsys.readouterr().out
    told = [
        "Generating waypoints from tlog...",
        " Generated 100 waypoints from tlog",
        "Connecting to vehicle on: ",
        "Uploading 100 waypoints to vehicle...",
        "Arm and Takeoff",
        " Waiting for vehicle to initialise...",
        " Waiting for arming...",
        " Taking off!",
        " Altitude: ",
        " Reached target altitude of ~30",
        "Starting mission",
        "Distance to waypoint (1): ",
        "Return to launch",
        "Close vehicle object",
        "Completed...",
    ]
    places = [out.find(line) for line in told]
    assert -1 not in places
    assert places == sorted(places)


def test_a_reader_that_has_gone_is_no_failure() -> None:
    """``flight-replay --dry-run --json | head`` ends quietly."""
    program = [sys.executable, "-m", "flight_replay", "--dry-run", "--json"]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout and process.stderr
        process.stdout.close()
        told = process.stderr.read().decode()
    assert "Error" not in told
    assert "Exception" not in told


def test_interrupted_before_it_could_begin(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ctrl-C while the imports run is an interrupt like any other, and no traceback."""

    def interrupted() -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr("flight_replay.cli.main.main", interrupted)
    assert program.main() == 130
    assert capsys.readouterr().err == "flight-replay: error: interrupted\n"

"""output_step.py: outputs are checked first, and the results are lines of text or JSON."""

import io
import json
from pathlib import Path
from typing import Any

import pytest

from flight_replay.cli.flight_result import FlightResult
from flight_replay.cli.options import parse_options
from flight_replay.cli.output_step import ReplayResult, check_outputs, print_result, result_lines
from flight_replay.exceptions import FlightReplayError
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log
from flight_replay.output.console.console import PlainConsole
from tests.helpers.made_replays import made_replay


@pytest.fixture(scope="module")
def result() -> ReplayResult:
    """The made-up replay, with the sample log as the one that was read."""
    route, outcome = made_replay()
    return ReplayResult(read_log(sample_log()), (), route, FlightResult("ArduCopter V4.6.0", True, outcome))


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--save", "mission.doc"], r'mission\.doc: unknown suffix "\.doc"; use one of \.waypoints'),
        (["--plot", "plot.bmp"], r"plot\.bmp: unknown suffix .*\.png"),
        (["--report", "report.txt"], r"report\.txt: unknown suffix .*\.html"),
        (["--record", "missing/a.tlog"], r"cannot write missing/a\.tlog: no folder missing; create it first"),
        (["--gcs", "carrier pigeon"], "carrier pigeon"),
        (["--gcs", "tcpin:0.0.0.0:5760"], "add --gcs-open"),
        (["--connect", "udp:127.0.0.1:14550", "--gcs", "udp:127.0.0.1:14550"], "is used twice"),
    ],
)
def test_outputs_that_cannot_work_are_refused(argv: list[str], message: str) -> None:
    """Before anything is read or flown."""
    with pytest.raises(FlightReplayError, match=message):
        check_outputs(parse_options(argv))


def test_outputs_that_can_work_are_accepted(tmp_path: Path) -> None:
    """Suffixes are known and folders exist."""
    files = ["--save", "a.plan", "--plot", "a.png", "--report", "a.html", "--record", "a.tlog"]
    stations = ["--connect", "tcp:[::1]:5760", "--gcs", "tcpin:[::]:5761", "--gcs-open"]
    check_outputs(parse_options(stations + [str(tmp_path / text) if "." in text else text for text in files]))


def test_result_lines_fit_80_columns(result: ReplayResult) -> None:
    """Each error has its own line, with mean, 95th percentile and maximum."""
    lines = result_lines(result, [])
    assert max(map(len, lines)) <= 80
    names = [line.partition(":")[0].strip() for line in lines if ":" in line]
    assert names == [
        "Route",
        "Planned path error, recorded to planned",
        "Planned path error, planned to recorded",
        "Path error, recorded to flown",
        "Path error, flown to recorded",
        "Position error",
        "Height error",
        "At equal times",
        "Flown",
        "To fly all of it",
    ]


def test_the_json_object_goes_to_standard_output(
    result: ReplayResult, capsys: pytest.CaptureFixture[str]
) -> None:
    """With --json the console gets no lines."""
    stream = io.StringIO()
    print_result(parse_options(["--json"]), result, PlainConsole(stream), [])
    written: Any = json.loads(capsys.readouterr().out)
    assert set(written) == {"log", "route", "flight"}
    assert written["flight"]["vehicle"] == "ArduCopter V4.6.0"
    assert stream.getvalue() == ""

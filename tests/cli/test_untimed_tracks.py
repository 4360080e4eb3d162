"""A track without times: what can be done with it, and what is refused."""

import json
from pathlib import Path

import pytest

from flight_replay.cli.main import main
from tests.helpers.track_files import gpx, moving


@pytest.fixture
def track(tmp_path: Path) -> Path:
    """A GPX file without times."""
    path = tmp_path / "drawn.gpx"
    path.write_bytes(gpx(moving(timed=False)))
    return path


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--speed", "recorded"], "--speed recorded"),
        (["--mode", "guided"], "--mode guided"),
        (["--limits", "recorded", "--route", "fit"], "--limits recorded"),
        (["--from", "5", "--to", "6"], "--from and --to"),
    ],
)
def test_what_needs_times_is_refused_in_one_line(
    options: list[str], named: str, track: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the options to leave out."""
    assert main([str(track), "--dry-run", *options]) == 1
    assert capsys.readouterr().err == f"flight-replay: error: {track} has no times: leave out {named}\n"


@pytest.mark.parametrize("route", ["spacing", "fit"])
def test_spacing_and_fit_plan_it_in_space(
    route: str, track: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """There are path errors, and none at equal times."""
    assert main([str(track), "--dry-run", "--json", "--route", route, "--heading", "recorded"]) == 0
    output = capsys.readouterr()
    result = json.loads(output.out)
    assert "It has no times: only its line can be replayed" in output.err
    assert result["log"]["timed"] is False
    assert result["log"]["flights"][0] | {"length_m": 0} == {
        "number": 1,
        "start_s": None,
        "end_s": None,
        "fixes": 60,
        "length_m": 0,
        "highest_m": 49.0,
        "top_speed_m_s": None,
    }
    assert result["route"]["predicted"]["path_error_m"]["recorded_to_flown"]["mean"] < 1.0
    nothing = {"mean": None, "p95": None, "max": None}
    assert result["route"]["predicted"]["position_error_m"] == nothing
    assert result["route"]["predicted"]["height_error_m"] == nothing


@pytest.mark.realtime
def test_it_flies_and_is_measured_in_space(
    track: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Plot and report are drawn, and the part that was flown is told in fixes."""
    drawn = ["--plot", str(tmp_path / "plot.png"), "--report", str(tmp_path / "report.html")]
    options = ["--sim", "builtin", "--speedup", "20", "--duration", "20", "--json"]
    assert main([str(track), *options, *drawn]) == 0
    flight = json.loads(capsys.readouterr().out)["flight"]
    assert flight["path_error_m"]["recorded_to_flown"]["max"] < 2.0
    assert flight["position_error_m"]["mean"] is None
    assert flight["coverage"]["recorded_s"] is None
    assert flight["coverage"]["of_fixes"] == 60
    assert flight["not_measured"]["position_error_m"] == "the recording has no times"
    assert "60 recorded fixes" in (tmp_path / "report.html").read_text()


def test_info_leaves_its_times_out(track: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A dash stands for what is not known."""
    assert main([str(track), "--info"]) == 0
    assert capsys.readouterr().out.splitlines()[-1].split() == [
        "1",
        "-",
        "-",
        "245",
        "m",
        "49",
        "m",
        "-",
        "60",
    ]

"""--mode guided, from the log to RTL, on the built-in copter."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from flight_replay.cli.main import main
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server import launch
from flight_replay.vehicle import connect

GUIDED = ("--mode", "guided")
SAMPLE_HOME = Start(47.397742, 8.545594, 488.1)
SPEEDUP = 5.0
PART = ("--from", "85", "--to", "110")  # With the first turns of the sample flight.
LOW = ("--altitude", "10", "--takeoff-altitude", "10")
pytestmark = pytest.mark.usefixtures("folder")


@pytest.fixture
def vehicle() -> Iterator[str]:
    """The connection string of a simulated copter at the start of the sample flight."""
    with launch.run(SAMPLE_HOME, speedup=SPEEDUP) as running:
        yield running.connection


def summary_of(capsys: pytest.CaptureFixture[str], *argv: str) -> Any:
    """The JSON object of a run that ended as asked."""
    status = main([*GUIDED, *argv, "--json"])
    output = capsys.readouterr()
    assert status == 0, output.err
    return json.loads(output.out)


def planned(capsys: pytest.CaptureFixture[str], *argv: str) -> Any:
    """The route of a dry run."""
    summary = summary_of(capsys, "--dry-run", *argv)
    assert summary["flight"] is None
    return summary["route"]


def guid_timeout_s(connection: str) -> float:
    with connect(connection, speedup=SPEEDUP) as connected:
        return connected.parameters(["GUID_TIMEOUT"])["GUID_TIMEOUT"]


def test_a_part_is_followed_in_step(vehicle: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Place, height and heading are the recording's at equal times; parameters are restored.

    The bounds are for a busy machine, whose targets come late; tests/supervisor has narrower ones.
    """
    files = ["--record", "a.tlog", "--plot", "a.png", "--report", "a.html", "--save", "a.csv"]
    summary = summary_of(capsys, "--connect", vehicle, *PART, *LOW, "--duration", "all", *files)
    route, flight = summary["route"], summary["flight"]
    assert (route["method"], route["points"], route["items"]) == ("guided", 0, [])
    assert (flight["ended"], flight["waypoints_reached"], flight["rtl_confirmed"]) == (
        "recording complete",
        0,
        True,
    )
    assert flight["position_error_m"]["mean"] < 1.0
    assert flight["path_error_m"]["recorded_to_flown"]["mean"] < 1.0
    assert flight["path_error_m"]["flown_to_recorded"]["mean"] < 1.0
    assert flight["height_error_m"]["max"] < 1.0
    assert flight["heading_error_deg"]["mean"] < 20.0
    assert -2.0 < flight["auto_s"] - route["predicted_duration_s"] < 15.0
    assert flight["coverage"]["to_fly_all"] == []
    assert flight["not_measured"] == {}
    assert guid_timeout_s(vehicle) == 3.0
    for file in ("a.tlog", "a.png", "a.html", "a.csv"):
        assert (folder / file).stat().st_size > 1000
    assert b"GUID_TIMEOUT" in (folder / "a.tlog").read_bytes()


def test_each_pass_learns_from_those_before(
    vehicle: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The last pass alone is measured.

    The bounds are for a busy machine, as above; tests/supervisor has that the vehicle is nearer each time.
    """
    options = ("--duration", "all", "--passes", "2", "--json")
    status = main([*GUIDED, "--connect", vehicle, *PART, *LOW, *options])
    output = capsys.readouterr()
    flight = json.loads(output.out)["flight"]
    assert (status, flight["ended"], flight["rtl_confirmed"]) == (0, "recording complete", True)
    off_m = [float(off) for off in re.findall(r"Pass \d of 2: ([\d.]+) m", output.err)]
    assert len(off_m) == 1
    assert max(off_m) < 1.0
    assert 29.0 < flight["auto_s"] < 45.0
    assert flight["position_error_m"]["mean"] < 1.0
    assert guid_timeout_s(vehicle) == 3.0


def test_a_duration_ends_it(capsys: pytest.CaptureFixture[str]) -> None:
    """After so much of the recording, at half the pace after twice as long."""
    options = ["--sim", "builtin", "--speedup", "10", *PART, "--duration", "4", "--speed", "0.5x"]
    flight = summary_of(capsys, *options)["flight"]
    assert flight["ended"] == "duration"
    assert flight["coverage"]["recorded_s"] == pytest.approx(4.0, abs=0.8)
    assert 12.0 < flight["auto_s"] < 25.0  # 5 + 2 * 4, and longer on a busy machine, whose targets come late.
    assert flight["coverage"]["to_fly_all"] == ["--duration all"]


def test_plain_lines_say_what_happens(capsys: pytest.CaptureFixture[str]) -> None:
    """The lines of a flight in GUIDED come in this order, none of them speaks of a mission."""
    assert main([*GUIDED, *PART, "--sim", "builtin", "--speedup", "20", "--duration", "3"]) == 0
    out = capsys.readouterr().out
    lines = [
        "Generating the motion from tlog...",
        " Generated a motion of ",
        " The way to the first fix is flown at 10 m/s.",
        "Arm and Takeoff",
        " Reached target altitude of ~30",
        "Flying to where the recording begins",
        " Distance to the beginning: ",
        "Following the recording",
        " Begins in ",
        "Return to launch",
        "Completed...",
        " Route: 93 m, covers all 101 fixes",
        " At equal times: by the recording's clock, ",
        " s of GUIDED",
    ]
    places = [out.find(line) for line in lines]
    assert -1 not in places
    assert places == sorted(places)
    assert "aypoint" not in out


def test_a_dry_run_predicts_it(capsys: pytest.CaptureFixture[str]) -> None:
    """The motion's figures, and errors of a fraction of a metre."""
    route = planned(capsys)
    assert set(route["reference"]) == {
        "duration_s",
        "top_speed_m_s",
        "top_climb_m_s",
        "top_descent_m_s",
        "top_acceleration_m_s2",
        "lowest_m",
        "highest_m",
    }
    assert route["reference"]["top_speed_m_s"] < 12.0
    predicted = route["predicted"]
    assert predicted["position_error_m"]["mean"] < 0.2
    assert predicted["heading_error_deg"]["mean"] < 3.0
    assert route["heights"]["climb_to_first_m"] == pytest.approx(0.0, abs=0.05)


def test_the_vehicle_may_turn_as_it_wants(capsys: pytest.CaptureFixture[str]) -> None:
    """--heading vehicle sends no heading, and does not get it right."""
    asked, free = planned(capsys, *PART), planned(capsys, *PART, "--heading", "vehicle")
    own, recorded = (route["predicted"]["heading_error_deg"]["mean"] for route in (free, asked))
    assert own > 2 * recorded
    assert free["predicted"]["position_error_m"]["mean"] < 0.5


def test_a_slower_pace_is_easier(capsys: pytest.CaptureFixture[str]) -> None:
    """--speed 0.5x takes twice as long at half the speed."""
    whole, slow = planned(capsys, *PART), planned(capsys, *PART, "--speed", "0.5x")
    assert slow["predicted_duration_s"] - 5.0 == pytest.approx(
        2 * (whole["predicted_duration_s"] - 5.0), abs=0.1
    )
    top_m_s = whole["reference"]["top_speed_m_s"]
    assert slow["reference"]["top_speed_m_s"] == pytest.approx(top_m_s / 2, rel=0.15)
    assert slow["predicted"]["position_error_m"]["mean"] < whole["predicted"]["position_error_m"]["mean"]


def test_recorded_heights_can_be_raised(capsys: pytest.CaptureFixture[str]) -> None:
    """--altitude recorded+10 is ten metres above the recorded heights, which have their floor."""
    recorded = planned(capsys, *PART, "--altitude", "recorded", "--floor", "18")
    higher = planned(capsys, *PART, "--altitude", "recorded+10", "--floor", "18")
    assert recorded["reference"]["lowest_m"] == pytest.approx(18.0, abs=0.05)
    assert recorded["heights"]["raised_to_floor"]["fixes"] > 0
    assert higher["reference"]["highest_m"] == pytest.approx(
        recorded["reference"]["highest_m"] + 10.0, abs=0.2
    )
    assert higher["heights"]["raised_to_floor"]["fixes"] == 0
    assert higher["predicted"]["height_error_m"]["max"] < 0.5


def test_what_is_followed_is_saved_without_waypoints(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """--save writes home and the recorded track, KML the line that is followed too, a place a second."""
    names = ("a.kml", "a.gpx", "a.csv", "a.geojson")
    planned(capsys, *PART, *(text for name in names for text in ("--save", name)))
    kml, gpx, csv, geojson = ((folder / name).read_text(encoding="utf-8") for name in names)
    places = re.findall("<name>(.*)</name>", kml)
    assert places == ["Flight replay", "Mission", "Home", "Route", "Recorded track", "Recorded flight"]
    assert len(kml.partition("<name>Route</name>")[2].partition("</coordinates>")[0].splitlines()) > 20
    assert "<rte>" not in gpx and "<trkpt" in gpx
    assert {line.partition(",")[0] for line in csv.splitlines()} == {"kind", "home", "track"}
    assert {each["properties"]["kind"] for each in json.loads(geojson)["features"]} == {"home", "track"}


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--mode", "guided", "--route", "fit"], "leave out --route fit"),
        (["--mode", "guided", "--limits", "recorded"], "cannot be used with --mode guided"),
        (["--mode", "guided", "--save", "a.kml", "--save", "a.Plan"], "--save a.Plan cannot be used with"),
        (["--mode", "guided", "--save", "a.waypoints"], "use --route fit --speed recorded instead"),
        (["--speed", "0.5x"], "needs --mode guided"),
        (["--mode", "guided", "--speed", "0x"], "--speed"),
        (["--mode", "guided", "--max-error", "0"], "--max-error"),
        (["--mode", "gided"], "--mode"),
        (["--altitude", "recorded+"], "--altitude"),
        (["--altitude", "recorded-3"], "--altitude"),
    ],
)
def test_wrong_combinations_are_usage_errors(
    argv: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The exit status is 2, and the message says what to change."""
    assert main([*argv, "--dry-run"]) == 2
    assert message in capsys.readouterr().err

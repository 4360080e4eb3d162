"""Every output file of one flight, read with the programs that people use for them."""

from __future__ import annotations

import csv
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import pytest

from flight_replay.cli.main import main
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log
from flight_replay.mission import formats
from tests.mission.formats.test_qgc_plan import PLAN_SCHEMA

pytestmark = [pytest.mark.slow, pytest.mark.realtime]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with every output file of a sample flight."""
    folder = tmp_path_factory.mktemp("written")
    options = ["--tlog", str(sample_log()), "--sim", "builtin", "--speedup", "20", "--duration", "20", "-q"]
    for suffix in formats.SAVED_SUFFIXES:
        options += ["--save", str(folder / f"mission{suffix}")]
    for name in ("plot.png", "report.html", "record.tlog"):
        options += [f"--{name.partition('.')[0]}", str(folder / name)]
    assert main(options) == 0
    return folder


def test_pymavlink_loads_the_mission(written: Path) -> None:
    """Home, take-off, 100 waypoints and return, the same as in the .plan."""
    mavwp = pytest.importorskip("pymavlink.mavwp")
    loader = mavwp.MAVWPLoader()
    assert loader.load(str(written / "mission.waypoints")) == 103
    one, other = (formats.load_mission(written / f"mission{s}") for s in formats.LOADED_SUFFIXES)
    assert len(one.items) == len(other.items) == 102
    for item, same in zip(one.items, other.items, strict=True):
        assert (item.lat_deg, item.lon_deg) == pytest.approx((same.lat_deg, same.lon_deg), abs=1e-8)


def test_the_plan_keeps_to_its_schema(written: Path) -> None:
    """The schema is that of QGroundControl's developer guide."""
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.validate(json.loads((written / "mission.plan").read_text(encoding="utf-8")), PLAN_SCHEMA)


@pytest.mark.parametrize("kind", ["kml", "gpx"])
def test_gpsbabel_finds_every_waypoint_and_the_track(written: Path, kind: str) -> None:
    """100 waypoints, home, and the recorded fixes that the route covers."""
    if shutil.which("gpsbabel") is None:
        pytest.skip("gpsbabel is not installed")
    out = written / f"from-{kind}.gpx"
    command = ["gpsbabel", "-w", "-r", "-t", "-i", kind, "-f", str(written / f"mission.{kind}"), "-o", "gpx"]
    subprocess.run([*command, "-F", str(out)], check=True, timeout=30, capture_output=True)
    names = [element.tag.rpartition("}")[2] for element in Xml.parse(out).getroot().iter()]
    assert names.count("wpt") + names.count("rtept") == 101
    assert names.count("trkpt") >= len(fixes(written))


def fixes(written: Path) -> list[dict[str, str]]:
    """The track's rows in the table."""
    with (written / "mission.csv").open(newline="", encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["kind"] == "track"]


def test_geojson_and_csv_hold_the_same_track(written: Path) -> None:
    """Fix by fix; GeoJSON has the longitude first."""
    features: list[Any] = json.loads((written / "mission.geojson").read_text(encoding="utf-8"))["features"]
    (track,) = [each for each in features if each["properties"]["kind"] == "track"]
    rows = fixes(written)
    assert [row[:2] for row in track["geometry"]["coordinates"]] == [
        [float(row["lon_deg"]), float(row["lat_deg"])] for row in rows
    ]


def test_the_flight_was_recorded_as_a_log_that_can_be_replayed(written: Path) -> None:
    """The recording has the vehicle's positions, up to an altitude of 30 m."""
    track = read_log(written / "record.tlog").track
    assert len(track) > 50
    assert track.alt_m.max() == pytest.approx(30, abs=1)


def test_pictures_and_report_are_there(written: Path) -> None:
    """A PNG, and a page with the result."""
    assert (written / "plot.png").read_bytes().startswith(b"\x89PNG")
    page = (written / "report.html").read_text(encoding="utf-8")
    assert "Flown for the requested duration." in page
    assert "ArduCopter" in page

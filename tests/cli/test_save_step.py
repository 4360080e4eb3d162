"""save_step.py: the mission is saved before the flight, and what was flown after it."""

import re
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import pytest

from flight_replay.cli.flight_step import FlightResult
from flight_replay.cli.options import Options, parse_options
from flight_replay.cli.output_step import ReplayResult
from flight_replay.cli.save_step import save_flown, save_mission
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log
from tests.helpers.made_replays import made_following, made_replay


@pytest.fixture(scope="module", params=[made_replay, made_following], ids=["mission", "motion"])
def result(request: pytest.FixtureRequest) -> ReplayResult:
    """A made-up replay, whose log tells the time of day."""
    route, record, outcome = request.param()
    log = replace(read_log(sample_log()), track=route.recording, start_utc_s=1_700_000_000.0)
    return ReplayResult(log, (), route, FlightResult("ArduCopter V4.6.0", True, record, outcome))


def saved(folder: Path, result: ReplayResult, *names: str) -> Options:
    """The options of such a replay, whose missions are saved."""
    options = parse_options([text for name in names for text in ("--save", str(folder / name))])
    save_mission(options, result.route, result.log)
    return options


def test_after_the_flight_kml_has_what_was_flown(tmp_path: Path, result: ReplayResult) -> None:
    """At the first waypoint its clock is the recording's at the first fix; other files stay as they were."""
    options = saved(tmp_path, result, "a.kml", "a.gpx", "a.csv")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert save_flown(options, result) == []
    after = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert [name for name in before if after[name] != before[name]] == ["a.kml"]
    page = after["a.kml"].decode()
    assert page.count("<name>Flown by flight-replay</name>") == 2
    flown = page[page.rindex("<name>Flown by flight-replay</name>") :]
    assert result.flight is not None and result.flight.outcome.first_waypoint_s is not None
    late_s = float(result.flight.record.flown.time_s[0]) - result.flight.outcome.first_waypoint_s
    first = re.search("<when>(.*)Z</when>", flown)
    assert first is not None
    begun = datetime.fromisoformat(first[1] + "+00:00").timestamp()
    assert begun == pytest.approx(1_700_000_000.0 + late_s, abs=0.001)


def test_a_plan_that_was_not_flown_stays_as_it_is(tmp_path: Path, result: ReplayResult) -> None:
    """Nothing is written twice."""
    options = saved(tmp_path, result, "a.kml")
    (tmp_path / "a.kml").unlink()
    assert save_flown(options, replace(result, flight=None)) == []
    assert not (tmp_path / "a.kml").exists()


def test_a_file_that_cannot_be_written_after_the_flight_is_told(tmp_path: Path, result: ReplayResult) -> None:
    """In one sentence; the others are written."""
    folder = tmp_path / "gone"
    folder.mkdir()
    options = saved(tmp_path, result, "gone/a.kml", "b.kml")
    (folder / "a.kml").unlink()
    folder.rmdir()
    (problem,) = save_flown(options, result)
    assert "a.kml" in problem
    assert "Flown by" in (tmp_path / "b.kml").read_text(encoding="utf-8")

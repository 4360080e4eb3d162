"""save_step.py: the mission is saved before the flight, and what was flown after it."""

import re
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from flight_replay.cli.flight_result import FlightResult
from flight_replay.cli.main import main
from flight_replay.cli.options import Options, parse_options
from flight_replay.cli.output_step import ReplayResult
from flight_replay.cli.save_step import save_flown, save_mission
from flight_replay.geometry.arrays import Floats
from flight_replay.logs.flights import select
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log
from flight_replay.logs.track import Armed
from flight_replay.output.outcome import Outcome
from flight_replay.planning.route import Route
from tests.helpers.made_replays import made_following, made_replay


@pytest.fixture(scope="module", params=[made_replay, made_following], ids=["mission", "motion"])
def result(request: pytest.FixtureRequest) -> ReplayResult:
    """A made-up replay, whose log tells the time of day."""
    return result_of(*request.param())


def result_of(route: Route, outcome: Outcome) -> ReplayResult:
    """A replay whose log tells the time of day."""
    log = replace(read_log(sample_log()), track=route.recording, start_utc_s=1_700_000_000.0)
    return ReplayResult(log, (), route, FlightResult("ArduCopter V4.6.0", True, outcome))


def saved(folder: Path, result: ReplayResult, *names: str) -> Options:
    """The options of such a replay, whose missions are saved."""
    options = parse_options([text for name in names for text in ("--save", str(folder / name))])
    save_mission(options, result.route, result.log, result.log.track)
    return options


def test_after_the_flight_kml_has_what_was_flown(tmp_path: Path, result: ReplayResult) -> None:
    """At the first waypoint its clock is the recording's at the first fix; other files stay as they were."""
    options = saved(tmp_path, result, "a.kml", "a.gpx", "a.csv")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert save_flown(options, result, result.log.track) == []
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


def flown_s(path: Path) -> Floats:
    """The times of what was flown in a file of KML, from the recording's first fix on."""
    flown = path.read_text(encoding="utf-8").rpartition("<name>Flown by flight-replay</name>")
    whens = re.findall("<when>(.*)Z</when>", flown[2])
    times_s = np.array([datetime.fromisoformat(when + "+00:00").timestamp() for when in whens])
    return np.asarray(times_s - 1_700_000_000.0)


def test_what_followed_is_beside_the_recording_at_a_pace_and_where_that_waited(tmp_path: Path) -> None:
    """At half the recorded speed, with a wait of 5 s: the clock is that of the recording all the way."""
    made = result_of(*made_following(pace=0.5, waits_at_s=40.0, waits_s=5.0))
    options = saved(tmp_path, made, "a.kml")
    assert save_flown(options, made, made.log.track) == []
    times_s = flown_s(tmp_path / "a.kml")
    assert made.flight is not None and made.flight.record.recording_s is not None
    wanted_s = made.flight.record.recording_s
    at_all = wanted_s >= 0
    assert len(times_s) == len(wanted_s)
    assert times_s[at_all] == pytest.approx(0.5 * wanted_s[at_all], abs=0.002)


def test_what_was_flown_waits_where_the_recording_was_on_the_ground(tmp_path: Path) -> None:
    """The replay goes on from flight to flight; beside the recording it stands still in between."""
    result = result_of(*made_replay())
    recorded, flight = result.log.track, result.flight
    assert flight is not None and flight.outcome.first_waypoint_s is not None
    armed = np.full(len(recorded), Armed.YES, np.int8)
    armed[[0, 1, 200, 201]] = Armed.NO
    late_s = np.where(np.arange(len(recorded)) > 200, 600.0, 0.0)
    track = replace(recorded, armed=armed, time_s=recorded.time_s + late_s)
    made = replace(result, log=replace(result.log, track=track))
    options = saved(tmp_path, made, "a.kml")
    assert save_flown(options, made, track) == []
    own_s = flight.record.flown.time_s - flight.outcome.first_waypoint_s
    apart_s = flown_s(tmp_path / "a.kml") - own_s
    assert apart_s[0] == pytest.approx(track.time_s[2] - track.time_s[0], abs=0.002)
    assert apart_s[-1] == pytest.approx(apart_s[0] + 600.0, abs=2.0)


def test_all_that_was_recorded_is_saved(tmp_path: Path) -> None:
    """A route covers a part of it; a replay of the file is one of all that was selected."""
    path = tmp_path / "a.csv"
    argv = ["--tlog", str(sample_log()), "--from", "20", "--dry-run", "-q", "--save", str(path)]
    assert main(argv) == 0
    recorded = select(read_log(sample_log()).track, from_s=20.0)
    assert len(read_log(path).track) == len(recorded) > 2000


def test_a_plan_that_was_not_flown_stays_as_it_is(tmp_path: Path, result: ReplayResult) -> None:
    """Nothing is written twice."""
    options = saved(tmp_path, result, "a.kml")
    (tmp_path / "a.kml").unlink()
    assert save_flown(options, replace(result, flight=None), result.log.track) == []
    assert not (tmp_path / "a.kml").exists()


def test_a_file_that_cannot_be_written_after_the_flight_is_told(tmp_path: Path, result: ReplayResult) -> None:
    """In one sentence; the others are written."""
    folder = tmp_path / "gone"
    folder.mkdir()
    options = saved(tmp_path, result, "gone/a.kml", "b.kml")
    (folder / "a.kml").unlink()
    folder.rmdir()
    (problem,) = save_flown(options, result, result.log.track)
    assert "a.kml" in problem
    assert "Flown by" in (tmp_path / "b.kml").read_text(encoding="utf-8")

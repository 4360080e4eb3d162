"""info_text.py: what a log holds, as a person reads it."""

import json
from pathlib import Path

import pytest

from flight_replay.cli.main import main
from flight_replay.logs.flights import find_flights
from flight_replay.logs.read_log import read_log
from flight_replay.logs.sample import sample_log
from flight_replay.logs.vehicles import VehicleId
from flight_replay.output.info_text import info_lines
from tests.helpers.log_writer import LogWriter, position_payload


def lines_of(path: Path) -> list[str]:
    """The lines about a log."""
    recording = read_log(path)
    return info_lines(recording, find_flights(recording.track))


def test_the_sample_flight_is_told() -> None:
    """File, vehicle, what was left out, and a row for its flight; all within 80 columns."""
    lines = lines_of(sample_log())
    assert max(map(len, lines[1:])) <= 80
    assert "Vehicle   quadcopter, ArduPilot, system 1:1" in lines
    assert "Fixes     2686" in lines
    assert "Left out  30 without a position, 1 rejected (no 3D fix)" in lines
    assert lines[-2] == "Flight  Start (UTC)  Duration  Length  Highest  Top speed  Fixes"
    assert lines[-1].split() == ["1", "22:14:02", "0:10:35", "1560", "m", "26", "m", "9.8", "m/s", "2541"]


def test_a_flight_just_below_home_is_not_minus_nothing(tmp_path: Path) -> None:
    """Its highest point is 0 m."""
    log = LogWriter()
    for number in range(20):
        log.heartbeat(armed=True).position(1_000 + 500 * number, 47.0 + number * 1e-5, 8.0, -0.1)
    path = tmp_path / "low.tlog"
    path.write_bytes(log.data)
    assert lines_of(path)[-1].split()[5] == "0"


def test_a_log_without_a_flight_says_so(tmp_path: Path) -> None:
    """A vehicle that neither was armed nor moved."""
    log = LogWriter()
    for at_ms in range(1_000, 9_000, 500):
        log.heartbeat().position(at_ms, 47.0, 8.0)
    path = tmp_path / "parked.tlog"
    path.write_bytes(log.data)
    assert lines_of(path)[-1] == "No flight is found: the vehicle was not armed, or did not move."


def test_the_other_vehicles_are_named(tmp_path: Path) -> None:
    """Whichever is chosen."""
    log = LogWriter()
    for at_ms in range(1_000, 9_000, 500):
        log.position(at_ms, 47.0, 8.0)
    log.add(33, position_payload(9_000), system=2)
    path = tmp_path / "two.tlog"
    path.write_bytes(log.data)
    for chosen, other in ((1, "2:1 (1 fix)"), (2, "1:1 (16 fixes)")):
        recording = read_log(path, vehicle=VehicleId(chosen))
        lines = info_lines(recording, find_flights(recording.track))
        assert f"Others    {other}; choose with --vehicle" in lines


def test_info_flies_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    """--info ends after the table, and with --json after one object that has only the log."""
    assert main([str(sample_log()), "--info", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert list(shown) == ["log"]
    assert shown["log"]["format"] == "tlog"
    assert shown["log"]["vehicle_type"] == "quadcopter"
    assert shown["log"]["flights"][0]["top_speed_m_s"] == pytest.approx(9.8, abs=0.05)
    assert main([str(sample_log()), "--info"]) == 0
    assert "Generating" not in capsys.readouterr().out

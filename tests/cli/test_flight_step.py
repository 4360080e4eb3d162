"""The steps in the air, with a vehicle that is there already: what is refused, kept, raised and asked."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from flight_replay.cli import flight_step
from flight_replay.cli.main import main
from flight_replay.cli.options import parse
from flight_replay.errors import MissionError
from flight_replay.events import VehicleState, ignore
from flight_replay.mission.formats import load_mission
from flight_replay.mission.items import Mission, waypoint
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server import launch
from flight_replay.vehicle.identity import Identity

SAMPLE_HOME = Start(47.397742, 8.545594, 488.1)
SPEEDUP = "20"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Run in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def vehicle() -> Iterator[str]:
    """A simulated copter where the sample flight began; its connection string."""
    with launch.run(SAMPLE_HOME, speedup=float(SPEEDUP)) as running:
        yield running.connection


def replayed(capsys: pytest.CaptureFixture[str], *argv: str) -> Any:
    """What --json tells of a flight that went as asked."""
    assert main([*argv, "--json"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)["flight"]


def test_the_mission_on_board_is_kept(vehicle: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A second replay saves the first one's mission, and says how to put it back."""
    flight = replayed(capsys, "--connect", vehicle, "--duration", "2", "--max-points", "3", "--land")
    assert flight["rtl_confirmed"]
    assert not list(folder.glob("mission-before-*"))
    assert main(["--connect", vehicle, "--duration", "2", "--max-points", "5"]) == 0
    assert "flight_replay.cli.restore" in capsys.readouterr().out
    (kept,) = folder.glob("mission-before-*.waypoints")
    assert len(load_mission(kept).items) == 3


def test_a_route_that_begins_far_away_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """A vehicle two kilometres from the recording is not even given the mission."""
    far = Start(SAMPLE_HOME.lat_deg + 0.018, SAMPLE_HOME.lon_deg, 488.0)
    with launch.run(far, speedup=float(SPEEDUP)) as running:
        assert main(["--connect", running.connection]) == 1
    said = capsys.readouterr()
    assert "--max-distance" in said.err
    assert "Uploading" not in said.out


def test_raised_limits_are_put_back(capsys: pytest.CaptureFixture[str], vehicle: str) -> None:
    """--limits recorded changes the vehicle for this flight only."""
    names = ["WPNAV_ACCEL", "WPNAV_JERK", "ANGLE_MAX"]
    before = parameters(vehicle, names)
    asked = ["--limits", "recorded", "--duration", "5", "--record", "flight.tlog"]
    assert replayed(capsys, "--connect", vehicle, *asked)["ended"] == "duration"
    assert parameters(vehicle, names) == before
    assert b"WPNAV_ACCEL" in Path("flight.tlog").read_bytes()


def parameters(connection: str, names: list[str]) -> dict[str, float]:
    """What the vehicle says of its parameters."""
    from flight_replay.vehicle import connect

    with connect(connection, speedup=float(SPEEDUP)) as connected:
        return connected.parameters(names)


def test_a_speedup_is_set_on_a_simulator_that_runs(vehicle: str, capsys: pytest.CaptureFixture[str]) -> None:
    """--speedup with --connect changes a simulator's clock; without, the clock is left alone."""
    replayed(capsys, "--connect", vehicle, "--speedup", "25", "--duration", "2")
    assert parameters(vehicle, ["SIM_SPEEDUP"]) == {"SIM_SPEEDUP": 25.0}


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_recording_that_fails_does_not_end_the_flight(
    vehicle: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The flight ends as asked and comes home; that the recording is incomplete is the one line."""
    options = ["--connect", vehicle, "--duration", "2", "--record", "/dev/full", "--json"]
    assert main(options) == 1
    said = capsys.readouterr()
    assert json.loads(said.out)["flight"]["rtl_confirmed"] is True
    assert "error: the recording /dev/full is incomplete: No space left on device" in said.err


def test_a_vehicle_that_is_carried_away_while_asked_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a person saw before saying yes must still hold afterwards."""
    real = Identity(1, 1, 2, 3, "4.6.0", takes_item_int=True, simulated=False)
    here = VehicleState(1.0, 47.0, 8.0, 0.0, (0, 0, 0), None, "STABILIZE", False)
    places = [here, replace(here, lat_deg=47.1)]
    connected = SimpleNamespace(
        identity=real, wait_position=lambda limit_s, listener: places.pop(0), fence_areas=lambda: ()
    )
    route = SimpleNamespace(mission=Mission((waypoint(47.001, 8.0, 30.0),)))
    said: list[str] = []
    console = SimpleNamespace(say=said.append)
    monkeypatch.setattr(flight_step, "ask_consent", lambda console: said.append("asked"))
    with pytest.raises(MissionError, match="the first waypoint is"):
        flight_step._check(parse(["--connect", "x"]), route, connected, console, ignore)  # type: ignore[arg-type]
    assert said[-1] == "asked"

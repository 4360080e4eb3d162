"""flight_step.py: what is checked, saved and changed on a vehicle that is already running."""

import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from flight_replay.cli import consent, flight_step
from flight_replay.cli.consent import ArmingConsent
from flight_replay.cli.main import main
from flight_replay.cli.options import parse_options
from flight_replay.events import VehicleState, ignore
from flight_replay.exceptions import MissionError, VehicleError
from flight_replay.mission.formats import load_mission
from flight_replay.mission.items import Mission, waypoint
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.server import launch
from flight_replay.vehicle import connect
from flight_replay.vehicle.identity import Identity
from tests.helpers.supervised import s_curve

SAMPLE_HOME = Start(47.397742, 8.545594, 488.1)
SPEEDUP = "20"
pytestmark = pytest.mark.usefixtures("folder")


@pytest.fixture
def vehicle() -> Iterator[str]:
    """The connection string of a simulated copter at the start of the sample flight."""
    with launch.run(SAMPLE_HOME, speedup=float(SPEEDUP)) as running:
        yield running.connection


def flown(capsys: pytest.CaptureFixture[str], *argv: str) -> Any:
    """The flight of the JSON object of a replay that ended as asked."""
    assert main([*argv, "--json"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)["flight"]


def test_the_mission_on_board_is_saved(
    vehicle: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A second replay saves the mission of the first, and shows how to restore it."""
    flight = flown(capsys, "--connect", vehicle, "--duration", "2", "--max-points", "3", "--land")
    assert flight["rtl_confirmed"]
    assert not list(folder.glob("mission-before-*"))
    assert main(["--connect", vehicle, "--duration", "2", "--max-points", "5"]) == 0
    assert "flight_replay.cli.restore" in capsys.readouterr().out
    (saved,) = folder.glob("mission-before-*.waypoints")
    assert len(load_mission(saved).items) == 3


def test_a_route_that_starts_far_away_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing is uploaded to a vehicle two kilometres from the recording."""
    far = Start(SAMPLE_HOME.lat_deg + 0.018, SAMPLE_HOME.lon_deg, 488.0)
    with launch.run(far, speedup=float(SPEEDUP)) as running:
        assert main(["--connect", running.connection]) == 1
    output = capsys.readouterr()
    assert "--max-distance" in output.err
    assert "Uploading" not in output.out


def test_raised_limits_are_restored(capsys: pytest.CaptureFixture[str], vehicle: str) -> None:
    """--limits recorded changes the parameters for this flight only."""
    names = ["WPNAV_ACCEL", "WPNAV_JERK", "ANGLE_MAX"]
    before = parameters(vehicle, names)
    options = ["--limits", "recorded", "--duration", "5", "--record", "flight.tlog"]
    assert flown(capsys, "--connect", vehicle, *options)["ended"] == "duration"
    assert parameters(vehicle, names) == before
    assert b"WPNAV_ACCEL" in Path("flight.tlog").read_bytes()


def parameters(connection: str, names: list[str]) -> dict[str, float]:
    """Some of the vehicle's parameters."""
    with connect(connection, speedup=float(SPEEDUP)) as connected:
        return connected.parameters(names)


def test_plans_are_for_the_vehicle_that_flies_them(vehicle: str, capsys: pytest.CaptureFixture[str]) -> None:
    """As slow as it flies; a dry run with --connect reads its limits and changes nothing."""
    slow = {"WPNAV_SPEED": 100.0, "WPNAV_ACCEL": 50.0, "WPNAV_JERK": 0.5}
    with connect(vehicle, speedup=float(SPEEDUP)) as connected:
        connected.set_known_parameters(slow)
    options = ["--connect", vehicle, "--max-points", "8", "--json"]
    assert main([*options, "--dry-run", "--speedup", "3"]) == 0
    planned = json.loads(capsys.readouterr().out)
    limits = planned["route"]["limits"]
    assert (limits["speed_m_s"], limits["accel_m_s2"], limits["jerk_m_s3"]) == (1.0, 0.5, 0.5)
    assert planned["flight"] is None
    assert parameters(vehicle, ["SIM_SPEEDUP"]) == {"SIM_SPEEDUP": float(SPEEDUP)}
    assert main([*options, "--duration", "all"]) == 0
    output = capsys.readouterr()
    replay = json.loads(output.out)
    assert replay["route"] == planned["route"]
    assert replay["flight"]["auto_s"] == pytest.approx(replay["route"]["predicted_duration_s"], abs=4.0)
    assert "Planned with the vehicle's limits: speed 1 m/s (default 10)" in output.err


def test_a_running_simulator_is_set_to_the_speedup(vehicle: str, capsys: pytest.CaptureFixture[str]) -> None:
    """--speedup with --connect changes SIM_SPEEDUP."""
    flown(capsys, "--connect", vehicle, "--speedup", "25", "--duration", "2")
    assert parameters(vehicle, ["SIM_SPEEDUP"]) == {"SIM_SPEEDUP": 25.0}


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_recording_that_fails_does_not_end_the_flight(
    vehicle: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The flight ends as asked; the error is that the recording is incomplete."""
    options = ["--connect", vehicle, "--duration", "2", "--record", "/dev/full", "--json"]
    assert main(options) == 1
    output = capsys.readouterr()
    assert json.loads(output.out)["flight"]["rtl_confirmed"] is True
    assert "error: recording /dev/full is incomplete: No space left on device" in output.err


def checked(
    monkeypatch: pytest.MonkeyPatch,
    options: Sequence[str],
    route: Any,
    shown: list[str],
    *,
    terminal: bool = True,
) -> ArmingConsent:
    """What asks for consent to arm a real vehicle; what a person sees is added to ``shown``."""
    real = Identity(1, 2, 3, "4.6.0", takes_item_int=True, simulated=False)
    connected: Any = SimpleNamespace(
        identity=real, wait_position=lambda limit_s, listener: HERE, fence_areas=lambda: ()
    )
    console: Any = SimpleNamespace(print=shown.append)
    if terminal:
        monkeypatch.setattr(consent, "_check_terminal", lambda: None)
    monkeypatch.setattr(consent, "ask_consent", lambda console: shown.append("asked"))
    confirm = flight_step._check_before_arming(
        parse_options(["--connect", "x", *options]), route, connected, console, ignore
    )
    assert confirm is not None
    return confirm


HERE = VehicleState(1.0, 47.0, 8.0, 0.0, (0, 0, 0), None, "STABILIZE", False)
NEAR = SimpleNamespace(mission=Mission((waypoint(47.001, 8.0, 30.0),)), reference=None)


def test_a_vehicle_that_is_moved_before_consent_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """The check is repeated after a person has consented."""
    positions, shown = [HERE, replace(HERE, lat_deg=47.1)], list[str]()
    confirm = checked(monkeypatch, [], NEAR, shown)
    with pytest.raises(MissionError, match="the first waypoint is"):
        confirm(lambda: positions.pop(0))
    assert shown[-1] == "asked"


def test_the_vehicle_is_shown_where_it_is_when_the_word_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not where it was before the upload; with --yes it is shown at once."""
    shown: list[str] = []
    confirm = checked(monkeypatch, [], NEAR, shown)
    assert shown == []
    assert confirm(lambda: replace(HERE, lat_deg=47.0005, battery_v=15.2))
    assert shown == [
        "Vehicle: ArduCopter 4.6.0 (quadcopter, system 1)",
        "Position: 47.0005000, 8.0000000",
        "Battery: 15.2 V",
        "First waypoint: 56 m away",
        "Route: 1 waypoint, up to 56 m away and 30 m above home",
        "asked",
    ]
    shown.clear()
    assert not checked(monkeypatch, ["--yes"], NEAR, shown)(lambda: HERE)
    assert shown[1] == "Position: 47.0000000, 8.0000000"


def test_without_a_terminal_nothing_is_uploaded_to_a_real_vehicle(monkeypatch: pytest.MonkeyPatch) -> None:
    """It could not be armed."""
    monkeypatch.setattr("sys.stdin", io.StringIO("fly\n"))
    with pytest.raises(VehicleError, match="no terminal to ask for confirmation; use --yes"):
        checked(monkeypatch, [], NEAR, [], terminal=False)


def told_before_following(monkeypatch: pytest.MonkeyPatch, speed_m_s: float) -> list[str]:
    """What a person is told before a real vehicle with this speed setting follows a reference."""
    route = SimpleNamespace(
        mission=Mission((waypoint(47.0001, 8.0, 30.0),)), reference=s_curve(),
        limits=VehicleLimits(limits=Limits(wp_speed_m_s=speed_m_s)),
    )  # fmt: skip
    shown: list[str] = []
    checked(monkeypatch, ["--mode", "guided"], route, shown)(lambda: HERE)
    return shown


def test_a_person_is_told_of_the_motion_before_a_real_vehicle_follows_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nothing is uploaded: there are no waypoints to speak of."""
    shown = told_before_following(monkeypatch, 10.0)
    assert "Beginning of the motion: 11 m away" in shown
    assert "Route: up to 11 m away and 30 m above home" in shown
    assert shown[-2].startswith("Motion: up to 2.4 m/s and ")
    assert shown[-2].endswith("never below 30 m above home")
    assert shown[-1] == "asked"


def test_a_motion_that_is_faster_than_a_real_vehicle_may_fly_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pytest.raises(MissionError, match=r"--speed 0\.5x"):
        told_before_following(monkeypatch, 1.5)

"""restore.py: the mission on board is saved before it is overwritten, and restored."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

import pytest

from flight_replay import vehicle
from flight_replay.cli import restore
from flight_replay.cli.restore import restore_command, save_mission_on_board
from flight_replay.events import Event, Notice
from flight_replay.exceptions import VehicleError
from flight_replay.mission.formats import load_mission
from flight_replay.mission.items import Home, Mission, change_speed, waypoint
from flight_replay.simulator.autopilot.faults import COPTER_3_3, Faults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server import launch
from tests.helpers.armed import wait_armed

NOW = datetime(2026, 11, 20, 23, 5, 7)
BEFORE = Mission(
    (waypoint(47.1, 8.1, 25.0, hold_s=3), change_speed(4.0), waypoint(47.2, 8.1, 26.0, spline=True))
)


class VehicleWithMission:
    """A vehicle with a mission on board."""

    def __init__(self, mission: Mission) -> None:
        self._mission = mission

    def mission_on_board(self) -> Mission:
        return self._mission


def test_without_a_mission_on_board_no_file_is_written(tmp_path: Path) -> None:
    """There is nothing to save."""
    assert save_mission_on_board(VehicleWithMission(Mission(())), tmp_path, NOW) is None
    assert list(tmp_path.iterdir()) == []


def test_the_file_is_named_by_its_time(tmp_path: Path) -> None:
    """A later replay does not overwrite the file of an earlier one."""
    path = save_mission_on_board(VehicleWithMission(BEFORE), tmp_path, NOW)
    assert path == tmp_path / "mission-before-20261120-230507.waypoints"
    assert path.is_file()


def test_two_missions_saved_in_the_same_second_have_two_files(tmp_path: Path) -> None:
    """Two vehicles may be flown from one folder at once."""
    other = Mission(BEFORE.items[:1])
    paths = [save_mission_on_board(VehicleWithMission(mission), tmp_path, NOW) for mission in (BEFORE, other)]
    assert [path.name for path in paths if path] == [
        "mission-before-20261120-230507.waypoints",
        "mission-before-20261120-230507-2.waypoints",
    ]
    assert [len(load_mission(path).items) for path in paths if path] == [3, 1]


@pytest.mark.parametrize(
    ("connection", "end"),
    [
        ("udp:127.0.0.1:14550", "udp:127.0.0.1:14550"),
        ("/dev/ttyUSB0", "/dev/ttyUSB0 115200"),
        ("/dev/serial/by-path/usb-0:2:1.0", "/dev/serial/by-path/usb-0:2:1.0 115200"),
    ],
)
def test_the_command_has_file_and_connection(connection: str, end: str) -> None:
    """A serial port needs its baud rate; blanks are quoted for the shell."""
    command = restore_command(Path("my missions/a.waypoints"), connection, 115200)
    assert command.endswith(end)
    assert shlex.split(command)[3] == "my missions/a.waypoints"


def test_a_saved_mission_is_restored(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Saved from one vehicle and restored on another, it has the same items."""
    path = save_mission_on_board(VehicleWithMission(BEFORE.with_home(Home(47.0, 8.0, 400.0))), tmp_path, NOW)
    assert path is not None
    with launch.run(Start(47.0, 8.0, 400.0), speedup=10.0) as running:
        assert restore.main([str(path), running.connection]) == 0
        with vehicle.connect(running.connection, speedup=10.0) as connected:
            found = connected.mission_on_board()
    assert [(i.command, i.lat_deg, i.lon_deg) for i in found.items[::2]] == [
        (i.command, i.lat_deg, i.lon_deg) for i in BEFORE.items[::2]
    ]
    assert found.items[1].params[1] == 4.0
    assert "Restored 3 mission items" in capsys.readouterr().out


def test_the_command_names_the_signing_key() -> None:
    """Without it the vehicle would ignore the upload."""
    command = restore_command(Path("a.waypoints"), "udp:1:2", 57600, Path("my key"))
    assert shlex.split(command)[3:] == ["--signing-key", "my key", "a.waypoints", "udp:1:2"]


@pytest.mark.parametrize(
    "row",
    ["1 0 3 70000 0 0 0 0 47 8 30 1", "1 0 300 16 0 0 0 0 47 8 30 1", "1 0 3 16 0 1e39 0 0 47 8 30 1"],
    ids=["command", "frame", "parameter"],
)
def test_a_mission_that_cannot_be_sent_is_told_before_connecting(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], row: str
) -> None:
    """One line with the line of the file; nothing listens at the connection, which is never tried."""
    path = tmp_path / "m.waypoints"
    path.write_text(f"QGC WPL 110\n{row}\n")
    assert restore.main([str(path), "tcp:127.0.0.1:1"]) == 1
    error = capsys.readouterr().err
    assert error.startswith(f"flight-replay: error: {path} line 2 has ")
    assert error.count("\n") == 1


def test_what_a_vehicle_says_cannot_control_the_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its firmware may call itself anything."""

    def connect(*_: object, listener: Callable[[Event], None], **__: object) -> None:
        listener(Notice("this is \x1b]0;title\x07"))
        raise VehicleError("no \x1b[31m")

    path = save_mission_on_board(VehicleWithMission(BEFORE), tmp_path, NOW)
    monkeypatch.setattr(vehicle, "connect", connect)
    assert restore.main([str(path), "tcp:127.0.0.1:1"]) == 1
    error = capsys.readouterr().err
    assert error == "this is \\x1b]0;title\\x07\nflight-replay: error: no \\x1b[31m\n"


def test_an_interrupted_restore_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit status 130, and what may be wrong now."""

    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    path = save_mission_on_board(VehicleWithMission(BEFORE), tmp_path, NOW)
    monkeypatch.setattr(vehicle, "connect", interrupt)
    assert restore.main([str(path), "tcp:127.0.0.1:1"]) == 130
    assert "interrupted; what is on board may be incomplete" in capsys.readouterr().err


def test_the_help_says_what_each_argument_is(capsys: pytest.CaptureFixture[str]) -> None:
    """A person reads it in the field, when a vehicle has the wrong mission."""
    assert restore.main(["--help"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "parameters-before-….parm" in shown
    assert "BAUD baud rate of a serial port (default: 57600)" in shown


def test_an_error_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file that does not exist is exit status 1, wrong usage is 2."""
    assert restore.main([str(tmp_path / "none.waypoints"), "tcp:127.0.0.1:5760"]) == 1
    assert capsys.readouterr().err.startswith("flight-replay: error: cannot read")
    assert restore.main(["one"]) == 2
    assert restore.main(["a", "b", "fast"]) == 2
    assert restore.main(["a", "b", "²"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [": error: " in line for line in lines] == [True] * 3


def test_parameters_are_put_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A .parm file has parameters, not a mission."""
    path = tmp_path / "parameters-before-20261122-120000.parm"
    path.write_text("GUID_TIMEOUT 3\n")
    with launch.run(Start(47.0, 8.0, 400.0), speedup=10.0, parameters={"GUID_TIMEOUT": 0.5}) as running:
        assert restore.main([str(path), running.connection]) == 0
        with vehicle.connect(running.connection, speedup=10.0) as connected:
            assert connected.parameters(["GUID_TIMEOUT"]) == {"GUID_TIMEOUT": 3.0}
    assert f"Restored GUID_TIMEOUT from {path}" in capsys.readouterr().out


def test_nothing_is_restored_on_an_armed_vehicle(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It would fly off at once: a mission and parameters are left as they are, and the exit status is 1."""
    path = save_mission_on_board(VehicleWithMission(BEFORE), tmp_path, NOW)
    parameters = tmp_path / "before.parm"
    parameters.write_text("WPNAV_SPEED 600\n")
    start, stays_armed = Start(47.0, 8.0, 400.0), {"DISARM_DELAY": 0.0}
    with launch.run(start, speedup=10.0, parameters=stays_armed) as running:
        with vehicle.connect(running.connection, speedup=10.0) as connected:
            wait_armed(connected)
        assert restore.main([str(path), running.connection]) == 1
        assert restore.main([str(parameters), running.connection]) == 1
        with vehicle.connect(running.connection, speedup=10.0) as connected:
            assert not connected.mission_on_board().items
            assert connected.parameters(["WPNAV_SPEED"]) == {"WPNAV_SPEED": 1000.0}
    output = capsys.readouterr()
    assert not output.out
    assert output.err.splitlines() == [
        f"flight-replay: error: the vehicle is armed, in GUIDED: {unchanged}; "
        "land and disarm it, then run this again"
        for unchanged in ("its mission is not replaced", "its parameters are not changed")
    ]


def test_parameters_that_are_not_confirmed_are_not_told_as_restored(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """3.3 has no GUID_TIMEOUT; what the vehicle has is set, and the exit status is 1."""
    path = tmp_path / "before.parm"
    path.write_text("GUID_TIMEOUT 3\nWPNAV_SPEED 600\n")
    with launch.run(Start(47.0, 8.0, 400.0), speedup=10.0, faults=Faults(firmware=COPTER_3_3)) as running:
        assert restore.main([str(path), running.connection]) == 1
        with vehicle.connect(running.connection, speedup=10.0) as connected:
            assert connected.parameters(["WPNAV_SPEED"]) == {"WPNAV_SPEED": 600.0}
    output = capsys.readouterr()
    assert f"Restored WPNAV_SPEED from {path}" in output.out
    assert "GUID_TIMEOUT" not in output.out
    assert "error: not restored: GUID_TIMEOUT (its firmware has no such parameter); check" in output.err

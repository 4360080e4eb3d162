"""Ctrl-C when a flight is over, and before its files are written."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from flight_replay.cli import flight_step
from flight_replay.cli.flight_result import FlightResult, ReplayInterrupted
from flight_replay.cli.main import main
from flight_replay.simulator.server import launch
from flight_replay.vehicle import connect
from flight_replay.vehicle.link.link import Link
from flight_replay.vehicle.protocol import parameters
from tests.helpers.fault_runs import START
from tests.helpers.made_replays import made_replay

pytestmark = pytest.mark.usefixtures("folder")
NAMES = ["WPNAV_ACCEL", "WPNAV_JERK", "ANGLE_MAX"]
SPEEDUP = 20.0
FLOWN = ["--limits", "recorded", "--duration", "3", "--max-points", "9", "--json"]


def put_back(monkeypatch: pytest.MonkeyPatch, before: Mapping[str, float]) -> list[str]:
    """Ctrl-C when the first parameter is put back; each time that they are is listed."""
    done: list[str] = []
    write = parameters._written

    def interrupted(link: Any, wanted: Mapping[str, float], *limits: float) -> dict[str, str]:
        if wanted.items() & before.items():
            done.append("put back")
            if len(done) == 1:
                raise KeyboardInterrupt
        return write(link, wanted, *limits)

    monkeypatch.setattr(parameters, "_written", interrupted)
    return done


def closing(monkeypatch: pytest.MonkeyPatch, before: Mapping[str, float]) -> list[str]:
    """Ctrl-C when the link is closed, which leaves another error behind."""
    close, done = Link.close, list[str]()

    def interrupted(link: Link) -> None:
        close(link)
        done.append("closed")
        if len(done) == 1:
            try:
                raise KeyboardInterrupt
            finally:
                raise RuntimeError("cannot notify on un-acquired lock")

    monkeypatch.setattr(Link, "close", interrupted)
    return done


@pytest.mark.parametrize("interrupt", [put_back, closing])
def test_ctrl_c_after_a_flight_keeps_all_of_it(
    interrupt: Callable[..., list[str]],
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Its files and --json are written, and its parameters are put back all the same."""
    with launch.run(START, speedup=SPEEDUP) as running:
        with connect(running.connection, speedup=SPEEDUP) as connected:
            before = connected.parameters(NAMES)
        done = interrupt(monkeypatch, before)
        files = ["--save", "flown.kml", "--report", "flown.html"]
        assert main([*FLOWN, "--connect", running.connection, *files]) == 130
        monkeypatch.undo()
        with connect(running.connection, speedup=SPEEDUP) as connected:
            assert connected.parameters(NAMES) == before
    output = capsys.readouterr()
    flight = json.loads(output.out)["flight"]
    assert (flight["ended"], flight["rtl_confirmed"]) == ("duration", True)
    assert "<name>Flown" in (folder / "flown.kml").read_text()
    assert "WPNAV_ACCEL" not in output.err
    assert output.err.endswith("flight-replay: error: interrupted\n")
    assert (folder / "flown.html").exists()
    assert not list(folder.glob("parameters-before-*"))
    assert done == (["put back"] * 2 if interrupt is put_back else ["closed"])


@pytest.mark.parametrize("quiet", [[], ["-q"]], ids=["", "quiet"])
def test_what_is_written_after_an_interrupt_is_told_before(
    quiet: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A plot takes seconds, and who waits for the prompt wants to know for what."""
    route, outcome = made_replay()
    told: list[str] = []

    def interrupt(*_: object) -> None:
        raise ReplayInterrupted(route, FlightResult("Copter", True, outcome))

    def draw(*_: object) -> None:
        told.append(capsys.readouterr().err)

    monkeypatch.setattr(flight_step, "fly", interrupt)
    monkeypatch.setattr("flight_replay.output.charts.plot.save_plot", draw)
    assert main(["--save", "a.kml", "--save", "a.waypoints", "--plot", "a.png", *quiet]) == 130
    assert told == [
        "Interrupted: writing what was flown to a.kml, a.png; another Ctrl-C ends the program at once\n"
    ]
    assert capsys.readouterr().err == "flight-replay: error: interrupted\n"

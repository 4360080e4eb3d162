"""The steps before the flight: what is read, chosen and planned is what was asked for."""

from pathlib import Path

import pytest

from flight_replay.cli import plan_step
from flight_replay.cli.options import parse
from flight_replay.events import Event, Notice, Progress
from flight_replay.logs.sample import sample_log
from flight_replay.planning.route import Route


def planned(*argv: str) -> tuple[Route, list[Event]]:
    """The route for a command line over the first minutes of the sample, and what was told meanwhile."""
    heard: list[Event] = []
    options = parse(["--tlog", str(sample_log()), "--to", "120", *argv])
    _, _, track = plan_step.read(options, heard.append)
    return plan_step.plan(options, track, heard.append), heard


def test_a_fit_tells_its_progress_and_what_it_expects() -> None:
    """--route fit covers what was flown, predicts it, and says how far the work is."""
    route, heard = planned("--route", "fit", "--speed", "recorded", "--max-points", "20")
    assert route.method == "fit"
    assert len(route.mission.waypoints) <= 20
    assert route.mission.home is not None
    assert route.predicted is not None
    assert route.predicted.path_error.mean < 2
    assert any(isinstance(event, Progress) and event.what == "fit" for event in heard)
    assert any(isinstance(event, Notice) and "left out" in event.text for event in heard)


def test_recorded_limits_are_planned_with() -> None:
    """--limits recorded raises what the recording needs, and nothing is raised without it."""
    raised, _ = planned("--limits", "recorded")
    assert raised.required_limits
    assert not planned()[0].required_limits


def test_several_vehicles_are_told_of(tmp_path: Path) -> None:
    """Who reads a log of two vehicles is told which one is replayed."""
    heard: list[Event] = []
    plan_step.read(parse(["--tlog", str(two_vehicles(tmp_path))]), heard.append)
    told = [event.text for event in heard if isinstance(event, Notice)]
    assert any("Vehicle 1:1 is replayed" in text and "7:1 (3 fixes)" in text for text in told)


def two_vehicles(folder: Path) -> Path:
    """A log in which vehicle 1 sends five positions, vehicle 7 three."""
    mavlink = pytest.importorskip("pymavlink.dialects.v20.common")
    path = folder / "two.tlog"
    with path.open("wb") as log:
        for system, fixes in ((1, 5), (7, 3)):
            sender = mavlink.MAVLink(None, srcSystem=system, srcComponent=1)
            for i in range(fixes):
                fix = sender.global_position_int_encode(
                    1000 * i, 473977420 + 400 * i, 85455940, 488_000, 0, 400, 0, 0, 0
                )
                stamp_us = 1_700_000_000_000_000 + 1_000_000 * i
                log.write(stamp_us.to_bytes(8, "big") + fix.pack(sender))
    return path

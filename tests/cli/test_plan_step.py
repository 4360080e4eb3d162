"""plan_step.py: the log is read and the route planned as the options ask."""

from pathlib import Path

import pytest

from flight_replay.cli import plan_step
from flight_replay.cli.options import parse_options
from flight_replay.events import Event, Notice, Progress
from flight_replay.logs.sample import sample_log
from flight_replay.planning.route import Route


def planned(*argv: str) -> tuple[Route, list[Event]]:
    """The route of the first two minutes of the sample flight, and the events meanwhile."""
    events: list[Event] = []
    options = parse_options(["--tlog", str(sample_log()), "--to", "120", *argv])
    _, _, track = plan_step.read_recording(options, events.append)
    return plan_step.plan_route(options, track, events.append), events


def test_a_fit_reports_progress_and_predicted_errors() -> None:
    """--route fit covers the flown part and predicts its errors."""
    route, events = planned("--route", "fit", "--speed", "recorded", "--max-points", "20")
    assert route.method == "fit"
    assert len(route.mission.waypoints) <= 20
    assert route.mission.home is not None
    assert route.predicted is not None
    path = route.predicted.path_m
    assert path.recorded_to_path.error.mean() < 2
    assert path.path_to_recorded.error.mean() < 2
    assert route.objective_m is not None
    assert any(isinstance(event, Progress) and event.what == "fit" for event in events)
    assert any(isinstance(event, Notice) and "left out" in event.text for event in events)


def test_heights_are_said() -> None:
    """The climb to the first waypoint, which takes time, and what is raised to the floor."""
    argv = ("--altitude", "recorded", "--floor", "8")
    (route, events), (level, _) = planned(*argv), planned(*argv, "--takeoff-altitude", "8")
    assert route.heights is not None
    assert level.heights is not None
    assert (route.heights.floor_m, route.heights.first_m, route.heights.takeoff_m) == (8.0, 8.0, 30.0)
    assert route.heights.raised.fixes > 0
    assert set(route.heights.notes) <= set(route.notes)
    assert any(isinstance(event, Notice) and "descends 22.0 m" in event.text for event in events)
    assert route.predicted_duration_s == pytest.approx(level.predicted_duration_s + route.heights.climb_s)


def test_recorded_limits_are_planned_with() -> None:
    """--limits recorded requires limits of the vehicle; without it none are required."""
    raised, _ = planned("--limits", "recorded")
    assert raised.required_limits
    assert not planned()[0].required_limits


def test_several_vehicles_are_reported(tmp_path: Path) -> None:
    """The notice names the vehicle that is replayed, and the others."""
    events: list[Event] = []
    plan_step.read_recording(parse_options(["--tlog", str(two_vehicles(tmp_path))]), events.append)
    notices = [event.text for event in events if isinstance(event, Notice)]
    assert any("Replaying vehicle 1:1" in text and "7:1 (3 fixes)" in text for text in notices)


def two_vehicles(folder: Path) -> Path:
    """A log with five positions of vehicle 1 and three of vehicle 7."""
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

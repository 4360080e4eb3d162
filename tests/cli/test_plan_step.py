"""plan_step.py: the log is read and the route planned as the options ask."""

from pathlib import Path

import numpy as np
import pytest

from flight_replay.cli import plan_step
from flight_replay.cli.options import Options, parse_options
from flight_replay.events import Event, Notice, Progress, ignore
from flight_replay.logs.sample import sample_log
from flight_replay.logs.track import Track
from flight_replay.planning.route import Route
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import sped_up, wander
from tests.helpers.log_writer import LogWriter


def track_and_options(*argv: str) -> tuple[Options, Track]:
    """The first two minutes of the sample flight, and options."""
    options = parse_options(["--tlog", str(sample_log()), "--to", "120", *argv])
    return options, plan_step.read_recording(options, ignore)[2]


def planned(*argv: str) -> tuple[Route, list[Event]]:
    """The route of the first two minutes of the sample flight, and the events meanwhile."""
    events: list[Event] = []
    options = parse_options(["--tlog", str(sample_log()), "--to", "120", *argv])
    _, _, track = plan_step.read_recording(options, events.append)
    return plan_step.Planner(options, track, events.append).route(VehicleLimits()), events


@pytest.mark.usefixtures("brief_search")
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
    assert any(isinstance(event, Notice) and "Left out" in event.text for event in events)


@pytest.mark.usefixtures("brief_search")
@pytest.mark.parametrize(
    ("argv", "times_as_fast", "told"),
    [
        ([], 2.0, "To let it keep up on a simulator, add --limits recorded."),
        (
            ["--connect", "udpin:"],
            2.0,
            "if it is simulated, else follow the recording more slowly, with --mode guided --speed 0.5x.",
        ),
        (
            ["--limits", "recorded"],
            8.0,
            "To let it keep up, follow the recording more slowly, with --mode guided --speed 0.5x.",
        ),
        ([], 0.5, None),
    ],
)
def test_what_lets_a_vehicle_keep_up_is_said(argv: list[str], times_as_fast: float, told: str | None) -> None:
    """Limits are raised for simulated vehicles only, and once."""
    options = parse_options(["--route", "fit", "--speed", "recorded", "--max-points", "12", *argv])
    track = sped_up(wander(3), times_as_fast)
    notes = plan_step.Planner(options, track, ignore).route(VehicleLimits()).notes
    assert [note for note in notes if "keep up, " in note or "simulator, add" in note] == (
        [] if told is None else [notes[-1]]
    )
    assert told is None or told in notes[-1]


def test_a_speed_that_is_not_reached_is_said() -> None:
    """Legs of 3 m are flown at some 1.5 m/s; the vehicle's own speed, and a slower one, need no words."""
    said = "The vehicle is expected to fly at up to 1."
    for speed, times in (("20", 1), ("1", 0), ("vehicle", 0)):
        route, events = planned("--speed", speed)
        assert sum(said in note for note in route.notes) == times
        assert sum(isinstance(event, Notice) and said in event.text for event in events) == times


@pytest.mark.parametrize(("times_as_fast", "told"), [(2.0, True), (0.1, False)])
def test_of_a_recorded_speed_that_is_not_reached_the_time_is_said(times_as_fast: float, told: bool) -> None:
    """Legs of 3 m are flown more slowly than any recording; one that creeps is kept up with."""
    options = parse_options(["--speed", "recorded", "--max-points", "30"])
    track = sped_up(wander(3), times_as_fast)
    notes = plan_step.Planner(options, track, ignore).route(VehicleLimits()).notes
    said = [note for note in notes if note.startswith("The vehicle is expected to take ")]
    assert [note.endswith("; --route fit keeps up better.") for note in said] == [True] * told


@pytest.mark.parametrize(("beyond", "told"), [(1, []), (30, [" Left out: 30 of 80 positions"])])
def test_a_part_of_the_log_beyond_a_jump_is_said(tmp_path: Path, beyond: int, told: list[str]) -> None:
    """It may be half of the flight; single positions are not missed."""
    log = LogWriter()
    for i in range(50 + beyond):
        log.position(1000 * i, 47.4 + 3e-5 * i + (0.1 if i >= 50 else 0.0))
    (tmp_path / "a.tlog").write_bytes(log.data)
    notices: list[Event] = []
    plan_step.read_recording(parse_options([str(tmp_path / "a.tlog")]), notices.append)
    said = [each.text for each in notices if isinstance(each, Notice) and "Left out:" in each.text]
    assert [text[: len(" Left out: 30 of 80 positions")] for text in said] == told


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
    longer_s = route.predicted_duration_s - level.predicted_duration_s
    assert longer_s == pytest.approx(route.heights.climb_s - level.heights.climb_s, abs=2.0)


@pytest.mark.usefixtures("brief_search")
@pytest.mark.parametrize("how", [("--route", "spacing"), ("--route", "fit"), ("--mode", "guided")])
def test_raised_heights_are_no_recorded_ones(how: tuple[str, ...]) -> None:
    """--altitude recorded+10 is flown 10 m higher; what is saved and drawn as recorded is what was."""
    points = () if "guided" in how else ("--max-points", "12")
    argv = (*how, *points, "--to", "60", "--altitude", "recorded")
    (plain, _), (higher, _) = planned(*argv), planned(*argv[:-1], "recorded+10")
    for name in ("covered", "recorded", "recording"):
        as_recorded, raised = getattr(plain, name), getattr(higher, name)
        fixes = min(len(as_recorded), len(raised))
        assert raised.alt_m[:fixes].tolist() == as_recorded.alt_m[:fixes].tolist()
        assert raised.amsl_m[:fixes].tolist() == as_recorded.amsl_m[:fixes].tolist()
    up_m = higher.recorded.alt_m + 10.0
    assert higher.wanted.up_m == pytest.approx(np.maximum(up_m, 5.0))


def test_recorded_limits_are_planned_with() -> None:
    """--limits recorded requires limits of the vehicle; without it none are required."""
    raised, _ = planned("--limits", "recorded")
    assert raised.required_limits
    assert not planned()[0].required_limits


def test_a_vehicle_with_the_defaults_is_planned_for_once() -> None:
    """What was planned before the vehicle was known is kept; notes are emitted with the route."""
    events: list[Event] = []
    planner = plan_step.Planner(*track_and_options("--altitude", "recorded"), events.append)
    assert [event.text for event in events if isinstance(event, Notice)] == [
        " Generated 76 waypoints from tlog"
    ]
    first, second = planner.route(VehicleLimits()), planner.route(VehicleLimits(vehicle="ArduCopter 4.6.0"))
    assert first.mission is second.mission
    assert (first.limits.vehicle, second.limits.vehicle) == (None, "ArduCopter 4.6.0")


@pytest.mark.usefixtures("brief_search")
@pytest.mark.parametrize("route", ["spacing", "fit"])
def test_a_slower_vehicle_is_planned_for(route: str) -> None:
    """It takes longer, and says with which limits; the number of waypoints is said once."""
    events: list[Event] = []
    arguments = track_and_options("--route", route, "--max-points", "12", "--to", "60")
    slow = VehicleLimits(Limits(wp_speed_m_s=1.0, wp_accel_m_s2=0.5), "ArduCopter 3.3.0")
    planned_slow = plan_step.Planner(*arguments, events.append).route(slow)
    as_usual = plan_step.Planner(*arguments, ignore).route(VehicleLimits())
    assert planned_slow.predicted_duration_s > 1.15 * as_usual.predicted_duration_s
    texts = [event.text for event in events if isinstance(event, Notice)]
    assert sum("Generated" in text for text in texts) == 1
    assert any("speed 1 m/s (default 10), acceleration 0.5 m/s²" in text for text in texts)


def test_limits_are_raised_from_those_of_the_vehicle() -> None:
    """A slower vehicle needs more of its limits raised; what is flown with is told."""
    arguments = track_and_options("--limits", "recorded")
    slow = VehicleLimits(Limits(wp_speed_m_s=0.5), "ArduCopter 3.3.0")
    route = plan_step.Planner(*arguments, ignore).route(slow)
    assert route.limits.limits.wp_speed_m_s == route.required_limits["wp_speed_m_s"] > 1.0
    assert route.limits.vehicle == "ArduCopter 3.3.0"


@pytest.mark.usefixtures("brief_search")
def test_a_simulator_starts_where_the_route_begins() -> None:
    """A fit leaves out what was not flown; home is that of its mission."""
    for route in ("spacing", "fit"):
        planner = plan_step.Planner(*track_and_options("--route", route, "--max-points", "5"), ignore)
        assert planner.route(VehicleLimits()).mission.home == planner.home


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

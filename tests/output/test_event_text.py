"""event_text.py: each event has its line, in the wording of DroneKit's example where that has one."""

import pytest

from flight_replay.events import (
    Climbing,
    DistanceToStart,
    DistanceToWaypoint,
    Event,
    Finished,
    Following,
    LinkLost,
    LinkRestored,
    Notice,
    Phase,
    PhaseStarted,
    Progress,
    ReturnCommanded,
    StatusText,
    TargetAltitudeReached,
    VehicleState,
    Waiting,
    WaypointReached,
)
from flight_replay.output.event_text import event_line, is_detail, is_problem

STATE = VehicleState(1.0, 47.0, 8.0, 30.0, (1.0, 0.0, 0.0), 90.0, "AUTO", armed=True)

EXAMPLE_LINES = [
    (PhaseStarted(Phase.CONNECT, "tcp:127.0.0.1:5760"), "Connecting to vehicle on: tcp:127.0.0.1:5760"),
    (PhaseStarted(Phase.UPLOAD, "100"), "Uploading 100 waypoints to vehicle..."),
    (PhaseStarted(Phase.UPLOAD, "1"), "Uploading 1 waypoint to vehicle..."),
    (PhaseStarted(Phase.PREARM), "Arm and Takeoff"),
    (Waiting(Phase.PREARM, ""), " Waiting for vehicle to initialise..."),
    (PhaseStarted(Phase.ARM), " Waiting for arming..."),
    (PhaseStarted(Phase.TAKEOFF), " Taking off!"),
    (Climbing(1.234, 28.5, 30.0), " Altitude: 1.23 < 28.50"),
    (TargetAltitudeReached(30.0), " Reached target altitude of ~30"),
    (PhaseStarted(Phase.MISSION), "Starting mission"),
    (DistanceToWaypoint(1, 3.02, 100), "Distance to waypoint (1): 3.02"),
    (PhaseStarted(Phase.RETURN), "Return to launch"),
    (PhaseStarted(Phase.CLOSE), "Close vehicle object"),
    (Finished("duration"), "Completed..."),
]
OTHER_LINES = [
    (PhaseStarted(Phase.UPLOAD), "Uploading the mission to vehicle..."),
    (Waiting(Phase.PREARM, "EKF is not ready"), " Waiting for vehicle to initialise... (EKF is not ready)"),
    (Waiting(Phase.CONNECT, "no heartbeat"), " Waiting for the vehicle... (no heartbeat)"),
    (DistanceToWaypoint(7, 3.02, 4, 3), "Distance to waypoint (3): 3.02"),
    (DistanceToWaypoint(2, None, 3), "Distance to waypoint (2): unknown"),
    (PhaseStarted(Phase.APPROACH), "Flying to where the recording begins"),
    (DistanceToStart(12.34), " Distance to the beginning: 12.3 m"),
    (PhaseStarted(Phase.FOLLOW), "Following the recording"),
    (Following(1.0, -4.2, 60.0, 0.02, waiting=False), " Begins in 5 s, 0.02 m off"),
    (Following(1.0, 12.3, 60.0, 0.234, waiting=False), " 12 of 60 s, 0.23 m off"),
    (Following(1.0, 12.3, 60.0, 3.5, waiting=True), " 12 of 60 s, 3.50 m off, waiting for the vehicle"),
    (WaypointReached(1, 12.34), " Reached waypoint (1) at 12.3 s"),
    (WaypointReached(7, 12.34, 3), " Reached waypoint (3) at 12.3 s"),
    (Notice("Flying the built-in copter"), "Flying the built-in copter"),
    (Notice("the route is long", warning=True), "Warning: the route is long"),
    (LinkLost(4.0), "Warning: link lost, no message from the vehicle for 4.0 s"),
    (LinkRestored(6.25), " Link restored after 6.2 s"),
    (ReturnCommanded(confirmed=True), " The vehicle confirmed RTL"),
    (ReturnCommanded(confirmed=False), "Warning: the vehicle did not confirm RTL"),
    (StatusText(4, "PreArm: Compass not calibrated"), ">>> PreArm: Compass not calibrated"),
]


@pytest.mark.parametrize(("event", "line"), EXAMPLE_LINES)
def test_lines_of_dronekits_example_are_kept(event: Event, line: str) -> None:
    """The wording is the example's, to the last blank and dot."""
    assert event_line(event) == line


@pytest.mark.parametrize(("event", "line"), OTHER_LINES)
def test_other_events_have_one_line(event: Event, line: str) -> None:
    """A wait shows its reason, a warning begins with the word."""
    assert event_line(event) == line


@pytest.mark.parametrize("event", [Progress("log", 1, 2, "bytes"), STATE])
def test_positions_and_progress_have_no_line(event: Event) -> None:
    """Only the live display and the map show them."""
    assert event_line(event) is None


@pytest.mark.parametrize(
    ("event", "expected"),
    [
        (LinkLost(4.0), True),
        (Notice("x", warning=True), True),
        (ReturnCommanded(confirmed=False), True),
        (Notice("x"), False),
        (ReturnCommanded(confirmed=True), False),
        (PhaseStarted(Phase.MISSION), False),
    ],
)
def test_problems_are_warnings_lost_links_and_unconfirmed_rtl(event: Event, expected: bool) -> None:
    """These are shown with -q too."""
    assert is_problem(event) is expected


@pytest.mark.parametrize(
    ("event", "expected"),
    [
        (StatusText(7, "x"), True),
        (StatusText(4, "x"), False),
        (WaypointReached(1, 2.0), True),
        (PhaseStarted(Phase.MISSION), False),
    ],
)
def test_details_are_minor_texts_and_reached_waypoints(event: Event, expected: bool) -> None:
    """Debugging texts are shown with -v only; the rest of what the autopilot says always."""
    assert is_detail(event) is expected

"""event_log.py: the events that the report lists."""

from flight_replay.events import (
    Climbing,
    DistanceToStart,
    DistanceToWaypoint,
    Event,
    Following,
    LinkLost,
    Phase,
    PhaseStarted,
    Progress,
    StatusText,
    VehicleState,
    Waiting,
)
from flight_replay.output.event_log import EventLog, LoggedEvent


def test_each_event_is_logged_once_with_the_vehicles_time() -> None:
    """Repeated readings are left out, a repeated wait is logged once, problems are marked."""
    log = EventLog()
    waiting = Waiting(Phase.PREARM, "EKF is not ready")
    events: list[Event] = [
        PhaseStarted(Phase.PREARM),
        waiting,
        waiting,
        VehicleState(12.5, 47.0, 8.0, 0.0, (0.0, 0.0, 0.0), None, "GUIDED", armed=False),
        Waiting(Phase.PREARM, "no fix"),
        Climbing(1.0, 28.5, 30.0),
        DistanceToWaypoint(1, 3.0, 9),
        Progress("Uploading", 1, 2, "items"),
        StatusText(6, "Arming motors"),
        LinkLost(4.0),
    ]
    for event in events:
        log.listener(event)
    assert log.entries == [
        LoggedEvent(None, "Arm and Takeoff", False),
        LoggedEvent(None, "Waiting for vehicle to initialise... (EKF is not ready)", False),
        LoggedEvent(12.5, "Waiting for vehicle to initialise... (no fix)", False),
        LoggedEvent(12.5, ">>> Arming motors", False),
        LoggedEvent(12.5, "Warning: link lost, no message from the vehicle for 4.0 s", True),
    ]


def test_following_is_logged_where_the_recording_begins_to_wait_or_goes_on() -> None:
    """Not every second: a report of ten minutes would list six hundred."""
    log = EventLog()
    log.listener(DistanceToStart(5.0))
    for second, waiting in enumerate([False, False, True, True, False, False]):
        log.listener(Following(float(second), second, 9.0, 0.25, waiting))
    assert [entry.text for entry in log.entries] == [
        "0 of 9 s, 0.25 m off",
        "2 of 9 s, 0.25 m off, waiting for the vehicle",
        "4 of 9 s, 0.25 m off",
    ]

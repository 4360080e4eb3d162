"""journal.py: what a report tells of the flight."""

from flight_replay.events import (
    Climbing,
    DistanceToWaypoint,
    Event,
    LinkLost,
    Phase,
    PhaseStarted,
    Progress,
    StatusText,
    VehicleState,
    Waiting,
)
from flight_replay.output.event_log import Entry, Journal


def test_a_journal_keeps_what_happened_once_with_the_vehicles_time() -> None:
    """Readings that repeat themselves are left out, a repeated wait is kept once, warnings are marked."""
    journal = Journal()
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
        journal.listener(event)
    assert journal.entries == [
        Entry(None, "Arm and Takeoff", False),
        Entry(None, "Waiting for vehicle to initialise... (EKF is not ready)", False),
        Entry(12.5, "Waiting for vehicle to initialise... (no fix)", False),
        Entry(12.5, "Autopilot: Arming motors", False),
        Entry(12.5, "Warning: nothing heard from the vehicle for 4.0 s", True),
    ]

"""The line of text for each event; where DroneKit's flight_replay example has a line, it is that one."""

from __future__ import annotations

import math
from functools import singledispatch

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
    PassFlown,
    Phase,
    PhaseStarted,
    ReturnCommanded,
    Severity,
    StatusText,
    TargetAltitudeReached,
    Waiting,
    WaypointReached,
)
from flight_replay.writing.counted import counted

_PHASES = {
    Phase.CONNECT: "Connecting to vehicle on: {}",
    Phase.UPLOAD: "Uploading {} to vehicle...",
    Phase.PREARM: "Arm and Takeoff",
    Phase.ARM: " Waiting for arming...",
    Phase.TAKEOFF: " Taking off!",
    Phase.MISSION: "Starting mission",
    Phase.APPROACH: "Flying to where the recording begins",
    Phase.FOLLOW: "Following the recording",
    Phase.RETURN: "Return to launch",
    Phase.CLOSE: "Close vehicle object",
}
_WAITS = {
    Phase.CONNECT: " Waiting for the vehicle...",
    Phase.PREARM: " Waiting for vehicle to initialise...",
    Phase.ARM: " Waiting for arming...",
    Phase.RETURN: " Waiting for the vehicle to return...",
}


def is_problem(event: Event) -> bool:
    """Whether the event is shown with ``-q`` too."""
    return (
        isinstance(event, LinkLost)
        or (isinstance(event, Notice) and (event.warning or event.asked_for))
        or (isinstance(event, ReturnCommanded) and not event.confirmed)
    )


def is_detail(event: Event) -> bool:
    """Whether the event is shown only with ``-v``."""
    debugging = isinstance(event, StatusText) and event.severity >= Severity.DEBUG
    return debugging or isinstance(event, WaypointReached)


@singledispatch
def event_line(event: object) -> str | None:
    """The line for an event; None for an event that has none, such as ``Progress`` or ``VehicleState``."""
    return None


@event_line.register
def _phase_started(event: PhaseStarted) -> str:
    detail = event.detail
    if event.phase is Phase.UPLOAD:
        detail = counted(int(detail), "waypoint") if detail else "the mission"
    return _PHASES[event.phase].format(detail)


@event_line.register
def _waiting(event: Waiting) -> str:
    line = _WAITS.get(event.phase, f" Waiting ({event.phase.value})...")
    return f"{line} ({event.reason})" if event.reason else line


@event_line.register
def _climbing(event: Climbing) -> str:
    return f" Altitude: {event.altitude_m:.2f} < {event.threshold_m:.2f}"


@event_line.register
def _target_altitude_reached(event: TargetAltitudeReached) -> str:
    return f" Reached target altitude of ~{event.target_m:g}"


@event_line.register
def _distance_to_waypoint(event: DistanceToWaypoint) -> str:
    distance = "unknown" if event.distance_m is None else f"{event.distance_m:.2f}"
    return f"Distance to waypoint ({event.number}): {distance}"


@event_line.register
def _distance_to_start(event: DistanceToStart) -> str:
    return f" Distance to the beginning: {event.distance_m:.1f} m"


@event_line.register
def _following(event: Following) -> str:
    waiting = ", waiting for the vehicle" if event.waiting else ""
    if event.recording_s < 0:
        return f" Begins in {math.ceil(-event.recording_s)} s, {event.error_m:.2f} m off{waiting}"
    return f" {event.recording_s:.0f} of {event.of_s:.0f} s, {event.error_m:.2f} m off{waiting}"


@event_line.register
def _pass_flown(event: PassFlown) -> str:
    return f" Pass {event.number} of {event.passes}: {event.off_m:.2f} m from the motion on average"


@event_line.register
def _waypoint_reached(event: WaypointReached) -> str:
    return f" Reached waypoint ({event.number}) at {event.time_s:.1f} s"


@event_line.register
def _status_text(event: StatusText) -> str:
    return f">>> {event.text}"


@event_line.register
def _notice(event: Notice) -> str:
    return f"Warning: {event.text}" if event.warning else event.text


@event_line.register
def _link_lost(event: LinkLost) -> str:
    return f"Warning: link lost, no message from the vehicle for {event.silent_s:.1f} s"


@event_line.register
def _link_restored(event: LinkRestored) -> str:
    return f" Link restored after {event.silent_s:.1f} s"


@event_line.register
def _return_commanded(event: ReturnCommanded) -> str:
    if event.confirmed:
        return " The vehicle confirmed RTL"
    return "Warning: the vehicle did not confirm RTL"


@event_line.register
def _finished(event: Finished) -> str:
    return "Completed..."

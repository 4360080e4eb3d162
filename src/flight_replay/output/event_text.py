"""Events in plain words: the lines of DroneKit's flight_replay example where it has one."""

from __future__ import annotations

from functools import singledispatch

from flight_replay.events import (
    Climbing,
    DistanceToWaypoint,
    Event,
    Finished,
    LinkLost,
    LinkRestored,
    Notice,
    Phase,
    PhaseStarted,
    ReturnCommanded,
    StatusText,
    TargetAltitudeReached,
    Waiting,
    WaypointReached,
)

WARNING_SEVERITY = 4
"""MAV_SEVERITY_WARNING: what the autopilot says from here down is always shown."""

_PHASES = {
    Phase.CONNECT: "Connecting to vehicle on: {}",
    Phase.UPLOAD: "Uploading {} waypoints to vehicle...",
    Phase.PREARM: "Arm and Takeoff",
    Phase.ARM: " Waiting for arming...",
    Phase.TAKEOFF: " Taking off!",
    Phase.MISSION: "Starting mission",
    Phase.RETURN: "Return to launch",
    Phase.CLOSE: "Close vehicle object",
}
_WAITS = {
    Phase.PREARM: " Waiting for vehicle to initialise...",
    Phase.ARM: " Waiting for arming...",
    Phase.RETURN: " Waiting for the vehicle to return...",
}


def went_wrong(event: Event) -> bool:
    """Whether the event is shown even to those who want to see only what went wrong."""
    return (
        isinstance(event, LinkLost)
        or (isinstance(event, Notice) and event.warning)
        or (isinstance(event, ReturnCommanded) and not event.confirmed)
    )


def is_detail(event: Event) -> bool:
    """Whether the event is shown only to those who want to see everything."""
    minor_words = isinstance(event, StatusText) and event.severity > WARNING_SEVERITY
    return minor_words or isinstance(event, WaypointReached)


@singledispatch
def sentence(event: object) -> str | None:
    """The line that says what happened; None for an event that has no line (progress, position)."""
    return None


@sentence.register
def _phase(event: PhaseStarted) -> str:
    return _PHASES[event.phase].format(event.detail or "the").replace("the waypoints", "the mission")


@sentence.register
def _waiting(event: Waiting) -> str:
    wait = _WAITS.get(event.phase, f" Waiting ({event.phase.value})...")
    return f"{wait} ({event.reason})" if event.reason else wait


@sentence.register
def _climbing(event: Climbing) -> str:
    return f" Altitude: {event.altitude_m:.2f} < {event.threshold_m:.2f}"


@sentence.register
def _up(event: TargetAltitudeReached) -> str:
    return f" Reached target altitude of ~{event.target_m:g}"


@sentence.register
def _heading(event: DistanceToWaypoint) -> str:
    distance = "unknown" if event.distance_m is None else f"{event.distance_m:.2f}"
    return f"Distance to waypoint ({event.seq}): {distance}"


@sentence.register
def _reached(event: WaypointReached) -> str:
    return f" Reached waypoint ({event.seq}) at {event.time_s:.1f} s"


@sentence.register
def _words(event: StatusText) -> str:
    return f" Autopilot: {event.text}"


@sentence.register
def _notice(event: Notice) -> str:
    return f"Warning: {event.text}" if event.warning else event.text


@sentence.register
def _lost(event: LinkLost) -> str:
    return f"Warning: nothing heard from the vehicle for {event.silent_s:.1f} s"


@sentence.register
def _back(event: LinkRestored) -> str:
    return f" The vehicle is heard again after {event.silent_s:.1f} s"


@sentence.register
def _return(event: ReturnCommanded) -> str:
    if event.confirmed:
        return " The vehicle confirmed RTL"
    return "Warning: the vehicle has not confirmed RTL"


@sentence.register
def _finished(event: Finished) -> str:
    return "Completed..."

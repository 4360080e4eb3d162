"""What happens during a replay, as plain records: supervisor and vehicle emit them, listeners show them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum


class Severity(IntEnum):
    """MAV_SEVERITY: the lower the number, the more serious the text."""

    EMERGENCY = 0
    ALERT = 1
    CRITICAL = 2
    ERROR = 3
    WARNING = 4
    NOTICE = 5
    INFO = 6
    DEBUG = 7


class Phase(Enum):
    """The phases of a replay once there is a vehicle, in order."""

    CONNECT = "connect"
    UPLOAD = "upload"
    PREARM = "prearm"
    ARM = "arm"
    TAKEOFF = "takeoff"
    MISSION = "mission"
    APPROACH = "approach"
    FOLLOW = "follow"
    RETURN = "return"
    CLOSE = "close"


@dataclass(frozen=True, slots=True)
class PhaseStarted:
    """A phase starts; ``detail`` names what it works on, such as a connection string."""

    phase: Phase
    detail: str = ""


@dataclass(frozen=True, slots=True)
class Progress:
    """``done`` of ``total`` units of a named task (bytes read, items uploaded, parameters)."""

    what: str
    done: int
    total: int
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Waiting:
    """A phase is waiting; ``reason`` is the autopilot's own text, empty if it gave none."""

    phase: Phase
    reason: str


@dataclass(frozen=True, slots=True)
class Climbing:
    """Altitude above home during take-off, which is complete at ``threshold_m``."""

    altitude_m: float
    threshold_m: float
    target_m: float


@dataclass(frozen=True, slots=True)
class TargetAltitudeReached:
    """Take-off is complete."""

    target_m: float


@dataclass(frozen=True, slots=True)
class DistanceToWaypoint:
    """Ground distance to the current mission item ``seq``; None where that item has no position.

    ``waypoint`` of ``waypoints`` is being flown to; speed changes and turns are items, but no waypoints.
    None stands for the number ``seq``, which it is in a mission of waypoints only.
    """

    seq: int
    distance_m: float | None
    waypoints: int
    waypoint: int | None = None

    @property
    def number(self) -> int:
        """Which waypoint it is, counted from 1."""
        return self.seq if self.waypoint is None else self.waypoint


@dataclass(frozen=True, slots=True)
class DistanceToStart:
    """Distance to where the recording begins, metres."""

    distance_m: float


@dataclass(frozen=True, slots=True)
class Following:
    """The recording's time that the vehicle is at, seconds of ``of_s``, and how far off it is, metres.

    ``time_s`` is by the vehicle's clock; ``waiting`` is whether the recording waits for the vehicle.
    """

    time_s: float
    recording_s: float
    of_s: float
    error_m: float
    waiting: bool


@dataclass(frozen=True, slots=True)
class PassFlown:
    """Pass ``number`` of ``passes`` taught the next; on average it was ``off_m`` from the motion."""

    number: int
    passes: int
    off_m: float


@dataclass(frozen=True, slots=True)
class WaypointReached:
    """The vehicle reached the waypoint that is mission item ``seq`` at ``time_s`` of its own clock.

    ``waypoint`` is its number among the waypoints; None stands for ``seq``, as in ``DistanceToWaypoint``.
    """

    seq: int
    time_s: float
    waypoint: int | None = None

    @property
    def number(self) -> int:
        """Which waypoint it is, counted from 1."""
        return self.seq if self.waypoint is None else self.waypoint


@dataclass(frozen=True, slots=True)
class VehicleState:
    """The vehicle's state at ``time_s`` of its own clock.

    ``alt_m`` is above home, in flight above that of its arming, ``velocity_m_s`` is (north, east, up).
    """

    time_s: float
    lat_deg: float
    lon_deg: float
    alt_m: float
    velocity_m_s: tuple[float, float, float]
    heading_deg: float | None
    mode: str
    armed: bool
    battery_v: float | None = None
    battery_percent: float | None = None


@dataclass(frozen=True, slots=True)
class StatusText:
    """A STATUSTEXT of the autopilot; ``severity`` is its MAV_SEVERITY."""

    severity: int
    text: str


@dataclass(frozen=True, slots=True)
class Notice:
    """A message of this program, one sentence; one that was ``asked_for`` is shown with ``-q`` too."""

    text: str
    warning: bool = False
    asked_for: bool = False


@dataclass(frozen=True, slots=True)
class LinkLost:
    """Nothing has been received from the vehicle for ``silent_s`` seconds."""

    silent_s: float


@dataclass(frozen=True, slots=True)
class LinkRestored:
    """The vehicle is received again after ``silent_s`` seconds."""

    silent_s: float


@dataclass(frozen=True, slots=True)
class ReturnCommanded:
    """RTL was commanded; ``confirmed`` if the vehicle then reported the mode RTL."""

    confirmed: bool


@dataclass(frozen=True, slots=True)
class Finished:
    """The replay is over; ``ended``, ``problem`` and ``landed`` are as in ``FlightRecord``."""

    ended: str
    problem: str | None = None
    landed: bool = False


Event = (
    PhaseStarted
    | Progress
    | Waiting
    | Climbing
    | TargetAltitudeReached
    | DistanceToWaypoint
    | DistanceToStart
    | Following
    | PassFlown
    | WaypointReached
    | VehicleState
    | StatusText
    | Notice
    | LinkLost
    | LinkRestored
    | ReturnCommanded
    | Finished
)
Listener = Callable[[Event], None]


def ignore(event: Event) -> None:
    """A listener that does nothing."""


class Relay:
    """A listener that passes events on to ``target``, which may change meanwhile."""

    def __init__(self, target: Listener) -> None:
        self.target = target

    def __call__(self, event: Event) -> None:
        """Pass an event on."""
        self.target(event)


def combine_listeners(*listeners: Listener) -> Listener:
    """One listener that calls each of ``listeners`` in order.

    An exception in one of them is logged and goes no further: a display must not end a flight.
    """

    def call_all(event: Event) -> None:
        for listener in listeners:
            try:
                listener(event)
            except Exception:
                import logging

                logging.getLogger(__name__).exception("a listener failed on %r", event)

    return call_all

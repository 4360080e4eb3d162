"""What happens during a replay, as plain records: the supervisor emits, console, map and report listen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum


class Severity(IntEnum):
    """MAV_SEVERITY: how much a status text matters; the lower, the more."""

    EMERGENCY = 0
    ALERT = 1
    CRITICAL = 2
    ERROR = 3
    WARNING = 4
    NOTICE = 5
    INFO = 6
    DEBUG = 7


class Phase(Enum):
    """The steps of a replay in the air, in order."""

    CONNECT = "connect"
    UPLOAD = "upload"
    PREARM = "prearm"
    ARM = "arm"
    TAKEOFF = "takeoff"
    MISSION = "mission"
    RETURN = "return"
    CLOSE = "close"


@dataclass(frozen=True, slots=True)
class PhaseStarted:
    """A step begins; ``detail`` names what it works on (a connection string, say)."""

    phase: Phase
    detail: str = ""


@dataclass(frozen=True, slots=True)
class Progress:
    """``done`` of ``total`` units of a named piece of work (bytes read, items sent, parameters)."""

    what: str
    done: int
    total: int
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Waiting:
    """A wait goes on; ``reason`` is the vehicle's own words where it gave any."""

    phase: Phase
    reason: str


@dataclass(frozen=True, slots=True)
class Climbing:
    """Height above home during take-off, and the height at which take-off counts as done."""

    altitude_m: float
    enough_m: float
    target_m: float


@dataclass(frozen=True, slots=True)
class TargetAltitudeReached:
    """Take-off is done."""

    target_m: float


@dataclass(frozen=True, slots=True)
class Heading:
    """The vehicle flies towards mission item ``seq``, ``distance_m`` ahead of it."""

    seq: int
    distance_m: float | None
    last_seq: int


@dataclass(frozen=True, slots=True)
class WaypointReached:
    """The vehicle reported mission item ``seq`` as reached, ``time_s`` by its own clock."""

    seq: int
    time_s: float


@dataclass(frozen=True, slots=True)
class VehicleState:
    """Where the vehicle was, by its own clock: degrees, metres above home, m/s north, east, up."""

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
    """Words of the autopilot, with their MAV_SEVERITY (0 emergency to 7 debug)."""

    severity: int
    text: str


@dataclass(frozen=True, slots=True)
class Notice:
    """One sentence of ours for the person watching."""

    text: str
    warning: bool = False


@dataclass(frozen=True, slots=True)
class LinkLost:
    """Nothing has come from the vehicle for ``silent_s`` seconds."""

    silent_s: float


@dataclass(frozen=True, slots=True)
class LinkBack:
    """The vehicle is heard again after ``silent_s`` seconds."""

    silent_s: float


@dataclass(frozen=True, slots=True)
class ReturnCommanded:
    """RTL was asked for; ``confirmed`` says whether the vehicle reported the mode."""

    confirmed: bool


@dataclass(frozen=True, slots=True)
class Finished:
    """The replay is over; ``ended`` says by what."""

    ended: str


Event = (
    PhaseStarted
    | Progress
    | Waiting
    | Climbing
    | TargetAltitudeReached
    | Heading
    | WaypointReached
    | VehicleState
    | StatusText
    | Notice
    | LinkLost
    | LinkBack
    | ReturnCommanded
    | Finished
)
Listener = Callable[[Event], None]


def ignore(event: Event) -> None:
    """A listener that does nothing."""


def together(*listeners: Listener) -> Listener:
    """One listener that tells all of them, in order; one that fails must not end a flight."""

    def tell(event: Event) -> None:
        for listener in listeners:
            try:
                listener(event)
            except Exception:
                import logging

                logging.getLogger(__name__).exception("a watcher failed at %r", event)

    return tell

"""What the supervisor needs of a vehicle and of a clock, and the reports that a vehicle sends.

Nothing here knows MAVLink: ``flight_replay.vehicle`` speaks it, and tests use a scripted vehicle.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from flight_replay.events import StatusText, VehicleState

Vector = tuple[float, float, float]


class Request(Enum):
    """What the supervisor requests of a vehicle."""

    MODE = "mode"
    ARM = "arm"
    TAKEOFF = "take-off"


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """The vehicle's flight mode, and whether it is armed."""

    mode: str
    armed: bool


@dataclass(frozen=True, slots=True)
class RequestAck:
    """The vehicle accepted a request, or refused it for ``reason``."""

    request: Request
    accepted: bool
    reason: str = ""


@dataclass(frozen=True, slots=True)
class RequestLost:
    """The vehicle answered something sent after a request, but not the request: it or its ack is lost."""

    request: Request


@dataclass(frozen=True, slots=True)
class MissionCurrent:
    """The item being flown (0 before the start), the number of items if known, and whether all are done."""

    seq: int
    total: int | None = None
    complete: bool = False


@dataclass(frozen=True, slots=True)
class MissionItemReached:
    """The vehicle reached item ``seq``."""

    seq: int


@dataclass(frozen=True, slots=True)
class HomePosition:
    """Where home is, ``amsl_m`` above sea level; told whenever somebody, or arming, sets it."""

    lat_deg: float
    lon_deg: float
    amsl_m: float


@dataclass(frozen=True, slots=True)
class PrearmStatus:
    """Whether the vehicle is ready to arm, and if not, what is missing."""

    ready: bool
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Rebooted:
    """The autopilot rebooted: its clock restarted, and nothing known before holds any longer."""


@dataclass(frozen=True, slots=True)
class Target:
    """Where to be and how to move in GUIDED: degrees, metres above home, m/s and m/s² north, east, up.

    ``heading_deg`` is clockwise from north, its rate degrees/s; None leaves the heading to the vehicle.
    """

    lat_deg: float
    lon_deg: float
    alt_m: float
    velocity_m_s: Vector
    acceleration_m_s2: Vector
    heading_deg: float | None
    heading_rate_deg_s: float


Report = (
    Heartbeat
    | VehicleState
    | StatusText
    | RequestAck
    | RequestLost
    | MissionCurrent
    | MissionItemReached
    | HomePosition
    | PrearmStatus
    | Rebooted
)


class Vehicle(Protocol):
    """A vehicle: requests return at once, and what comes of them arrives as reports."""

    def reports(self, timeout_s: float) -> Sequence[Report]:
        """All reports since the last call, in order; waits up to the timeout for the first.

        Raises:
            LinkFaultError: An error of this program keeps it from hearing the vehicle. It is raised once:
                what the vehicle is told after that, such as RTL, may be heard.
        """

    def request_mode(self, mode: str) -> None:
        """Request a flight mode; the next ``Heartbeat`` shows the mode that the vehicle is in."""

    def request_arm(self) -> None:
        """Request arming; the next ``Heartbeat`` shows whether the vehicle is armed."""

    def request_takeoff(self, altitude_m: float) -> None:
        """Request a take-off to ``altitude_m`` above home, in GUIDED."""

    def request_prearm_checks(self) -> None:
        """Request the pre-arm checks; failures arrive as ``StatusText``."""

    def mission_verified(self, while_waiting: Callable[[], None]) -> bool:
        """Whether the mission on board is, item for item, the one that was uploaded.

        The download can take long: ``while_waiting`` is called repeatedly meanwhile, and an
        exception that it raises ends the download.
        """

    def request_speed(self, speed_m_s: float) -> None:
        """Request a ground speed for flying to places in GUIDED."""

    def request_position(self, lat_deg: float, lon_deg: float, alt_m: float) -> None:
        """Request to fly to a place in GUIDED, at a height above home; positions show whether it does."""

    def request_speedup(self, speedup: float) -> None:
        """Request that a simulator's clock runs so many times as fast as wall-clock time."""

    @property
    def takes_targets(self) -> bool:
        """Whether enough is known of the vehicle's own frame to send it targets."""

    def send_target(self, target: Target) -> None:
        """Send a target that moves, to be followed until the next."""

    def round_trip_s(self) -> float:
        """Wall-clock seconds from a message to the vehicle until its answer."""


class Clock(Protocol):
    """Wall-clock time, which is independent of the vehicle's clock."""

    def monotonic_s(self) -> float:
        """Seconds that never run backwards."""


class WallClock:
    """The clock of this computer."""

    def monotonic_s(self) -> float:
        """Seconds that never run backwards."""
        return time.monotonic()

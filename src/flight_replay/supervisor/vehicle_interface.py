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
class PrearmStatus:
    """Whether the vehicle is ready to arm, and if not, what is missing."""

    ready: bool
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Rebooted:
    """The autopilot rebooted: its clock restarted, and nothing known before holds any longer."""


Report = (
    Heartbeat
    | VehicleState
    | StatusText
    | RequestAck
    | RequestLost
    | MissionCurrent
    | MissionItemReached
    | PrearmStatus
    | Rebooted
)


class Vehicle(Protocol):
    """A vehicle: requests return at once, and what comes of them arrives as reports."""

    def reports(self, timeout_s: float) -> Sequence[Report]:
        """All reports since the last call, in order; waits up to the timeout for the first."""

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


class Clock(Protocol):
    """Wall-clock time, which is independent of the vehicle's clock."""

    def monotonic_s(self) -> float:
        """Seconds that never run backwards."""


class WallClock:
    """The clock of this computer."""

    def monotonic_s(self) -> float:
        """Seconds that never run backwards."""
        return time.monotonic()

"""What the supervisor needs of a vehicle and of a clock, and the words in which a vehicle reports.

Nothing here knows MAVLink: ``flight_replay.vehicle`` speaks it, tests script it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from flight_replay.events import StatusText, VehicleState


class Request(Enum):
    """What the supervisor asks of a vehicle."""

    MODE = "mode"
    ARM = "arm"
    TAKEOFF = "take-off"


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """The vehicle's own word on its mode and whether its motors are armed."""

    mode: str
    armed: bool


@dataclass(frozen=True, slots=True)
class Answer:
    """The vehicle accepted a request or refused it, for ``reason``."""

    request: Request
    accepted: bool
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Unanswered:
    """The vehicle answered something sent after a request, but not the request: it or its answer is lost."""

    request: Request


@dataclass(frozen=True, slots=True)
class MissionAt:
    """The item being flown (0 before the start), the items on board if told, and whether all are done."""

    seq: int
    items: int | None = None
    complete: bool = False


@dataclass(frozen=True, slots=True)
class ItemReached:
    """The vehicle says that it reached item ``seq``."""

    seq: int


@dataclass(frozen=True, slots=True)
class Readiness:
    """Whether the vehicle can be armed, and if not, what is missing."""

    ready: bool
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Rebooted:
    """The vehicle's clock began anew: everything known of it is void."""


News = (
    Heartbeat
    | VehicleState
    | StatusText
    | Answer
    | Unanswered
    | MissionAt
    | ItemReached
    | Readiness
    | Rebooted
)


class Vehicle(Protocol):
    """A vehicle that is asked without waiting and reports when it reports."""

    def news(self, timeout_s: float) -> Sequence[News]:
        """Everything reported since the last call, in order; waits for the first until the timeout."""

    def ask_mode(self, mode: str) -> None:
        """Ask for a flight mode; a ``Heartbeat`` tells whether it was taken."""

    def ask_arm(self) -> None:
        """Ask to arm; a ``Heartbeat`` tells whether it was done."""

    def ask_takeoff(self, altitude_m: float) -> None:
        """Ask to climb to ``altitude_m`` above home, in GUIDED."""

    def ask_prearm_report(self) -> None:
        """Ask for the reasons against arming; they come as ``StatusText``."""

    def mission_verified(self, attend: Callable[[], None]) -> bool:
        """Whether the mission on board is, item for item, the one that was uploaded.

        ``attend`` is called now and then, as reading it can take long; what it raises ends the reading.
        """


class Clock(Protocol):
    """Time that passes here, whatever the vehicle's clock does."""

    def monotonic_s(self) -> float:
        """Seconds that never run backwards."""


class WallClock:
    """The clock of this machine."""

    def monotonic_s(self) -> float:
        """Seconds that never run backwards."""
        return time.monotonic()

"""A flight of the fake vehicle under the supervisor."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from flight_replay.events import Event
from flight_replay.supervisor import FlightRecord, Plan, fly
from tests.helpers.fake_vehicle import FakeClock, FakeVehicle, route

Setup = Callable[[FakeVehicle], None]
EventT = TypeVar("EventT")


class FakeFlight:
    """A flight of a fake vehicle, with the events that it emits."""

    def __init__(self, vehicle: FakeVehicle, **plan: object) -> None:
        self.vehicle = vehicle
        self.events: list[Event] = []
        self.plan = Plan(mission=route(vehicle.points), **plan)  # type: ignore[arg-type]
        self.began_s = vehicle.clock.now_s

    def fly(self) -> FlightRecord:
        return fly(self.vehicle, self.vehicle.clock, self.plan, self.events.append)

    def of(self, kind: type[EventT]) -> list[EventT]:
        """The events of one kind."""
        return [event for event in self.events if isinstance(event, kind)]

    @property
    def wall_s(self) -> float:
        """How long the flight took, wall-clock seconds."""
        return self.vehicle.clock.now_s - self.began_s


def fake_flight(vehicle: FakeVehicle | None = None, **plan: object) -> FakeFlight:
    return FakeFlight(vehicle or FakeVehicle(FakeClock()), **plan)

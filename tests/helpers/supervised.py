"""A flight of the fake vehicle under the supervisor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np
from scipy.interpolate import make_interp_spline

from flight_replay.events import Event
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.mission.items import Mission
from flight_replay.supervisor import FlightRecord, FollowPlan, Plan, fly
from flight_replay.supervisor.follower import Tuning
from tests.helpers.fake_vehicle import FRAME, FakeClock, FakeVehicle, route

RECORDED_S = 40.0

Setup = Callable[[FakeVehicle], None]
EventT = TypeVar("EventT")


class FakeFlight:
    """A flight of a fake vehicle, with the events that it emits."""

    def __init__(self, vehicle: FakeVehicle, plan: Plan | FollowPlan) -> None:
        self.vehicle, self.plan = vehicle, plan
        self.events: list[Event] = []
        self.began_s = vehicle.clock.now_s

    def fly_instead(self, mission: Mission) -> None:
        """Fly this mission, not that of the plan."""
        assert isinstance(self.plan, Plan)
        self.plan = replace(self.plan, mission=mission)

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
    """A flight of a mission."""
    flown = vehicle or FakeVehicle(FakeClock())
    return FakeFlight(flown, Plan(mission=route(flown.points), **plan))  # type: ignore[arg-type]


def fake_following(vehicle: FakeVehicle | None = None, **plan: object) -> FakeFlight:
    """A flight that follows an S of 40 m in 40 s, from 20 m beside home; targets are where it is to be."""
    flown = vehicle or FakeVehicle(FakeClock())
    plan = {"tuning": Tuning(braking_m_s2=0.0, braking_ahead_m=0.0)} | plan
    return FakeFlight(flown, FollowPlan(reference=s_curve(), recorded_s=RECORDED_S, **plan))  # type: ignore[arg-type]


def s_curve(frame: FlatFrame = FRAME, length_m: float = 40.0, alt_m: float = 30.0) -> ReferenceMotion:
    """The reference of ``fake_following``: at rest at both ends, nose north."""
    times_s = np.linspace(-5.0, RECORDED_S + 5.0, 200)
    share = np.clip(times_s / RECORDED_S, 0.0, 1.0)
    along = length_m * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    aside = 20.0 + 5.0 * np.sin(along * 40.0 / 6.0 / length_m)
    places = np.column_stack([along, aside, np.full(len(along), alt_m)])
    spline = make_interp_spline(times_s, places, k=5)
    heading = make_interp_spline(times_s, np.zeros((len(times_s), 1)), k=3)
    return ReferenceMotion(
        frame=frame, begin_s=-5.0, end_s=RECORDED_S + 5.0, position=spline, heading=heading
    )

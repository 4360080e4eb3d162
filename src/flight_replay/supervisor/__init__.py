"""The flight as phases with deadlines, and RTL on every way out: pure logic over a vehicle and a clock."""

from flight_replay.supervisor.flight_plan import Deadlines, FlightRecord, FollowPlan, Plan
from flight_replay.supervisor.fly import FlightInterrupted, fly
from flight_replay.supervisor.vehicle_interface import Clock, Vehicle, WallClock

__all__ = [
    "Clock",
    "Deadlines",
    "FlightInterrupted",
    "FlightRecord",
    "FollowPlan",
    "Plan",
    "Vehicle",
    "WallClock",
    "fly",
]

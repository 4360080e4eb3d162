"""The flight's phases, deadlines and the RTL promise: pure logic over a vehicle and a clock."""

from flight_replay.supervisor.contract import Clock, Vehicle, WallClock
from flight_replay.supervisor.fly import fly
from flight_replay.supervisor.plan import Deadlines, FlightRecord, Plan

__all__ = ["Clock", "Deadlines", "FlightRecord", "Plan", "Vehicle", "WallClock", "fly"]

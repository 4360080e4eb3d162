"""ArduPilot SITL: found, downloaded, started and stopped; or the built-in copter in its place."""

from flight_replay.vehicle.sitl.choose import simulator

__all__ = ["simulator"]

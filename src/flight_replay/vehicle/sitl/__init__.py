"""ArduPilot's software-in-the-loop simulator: found, downloaded, started and stopped."""

from flight_replay.vehicle.sitl.choose import simulator

__all__ = ["simulator"]

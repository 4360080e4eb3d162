"""Bytes of a telemetry log to a track: the only place that knows how logs frame MAVLink."""

from flight_replay.logs.tlog.reader import Log, read_log
from flight_replay.logs.tlog.vehicles import VehicleCount, VehicleId

__all__ = ["Log", "VehicleCount", "VehicleId", "read_log"]

"""Bytes of a telemetry log to a track: the only place that knows how logs frame MAVLink."""

from flight_replay.tlog.log import Log, read_log
from flight_replay.tlog.vehicles import VehicleCount, VehicleId

__all__ = ["Log", "VehicleCount", "VehicleId", "read_log"]

"""Bytes of a telemetry log to a track: the only place that knows how logs frame MAVLink."""

from flight_replay.tlog.log import Log, VehicleCount, VehicleId, read_log

__all__ = ["Log", "VehicleCount", "VehicleId", "read_log"]

"""Bytes of a telemetry log to a track: the only place that knows how logs frame MAVLink."""

"""MAVLink around the autopilot."""

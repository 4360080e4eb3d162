"""MAVLink services from the side of a ground station: commands, parameters, missions, telemetry."""

"""MAVLink's services, seen by a ground station: commands, parameters, missions, telemetry."""

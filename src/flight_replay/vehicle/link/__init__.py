"""The link to a vehicle: transports, MAVLink frames, discovery, and ground stations that share the link."""

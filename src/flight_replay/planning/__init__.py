"""From a recorded track to a route; no MAVLink, no clock."""

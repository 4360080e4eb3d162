"""The built-in copter: how ArduCopter flies a mission, and a MAVLink endpoint around it."""

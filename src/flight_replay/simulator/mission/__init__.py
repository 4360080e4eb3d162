"""ArduPilot's AP_Mission: what is stored, and in which order it is flown."""

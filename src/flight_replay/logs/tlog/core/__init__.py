"""What takes most of the time of reading a telemetry log, in C, where that is compiled."""

"""Recorded flights: the track, its flights, and the readers of log files."""

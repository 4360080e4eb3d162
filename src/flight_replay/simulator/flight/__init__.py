"""What a copter can be doing, and whole trajectories; no I/O, no clock."""

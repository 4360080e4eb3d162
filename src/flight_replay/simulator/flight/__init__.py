"""The flight model: modes, submodes and whole trajectories; no I/O, no clock."""

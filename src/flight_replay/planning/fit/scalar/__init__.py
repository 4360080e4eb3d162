"""What the fit computes for a few fixes and legs at a time, number by number: compiled in wheels."""

"""Whether the vehicle was armed, and in which mode, by heartbeats and what is said beside them."""

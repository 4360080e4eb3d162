"""Sockets, pacing, process, and the command ``flight-replay-sim``."""

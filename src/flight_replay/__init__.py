"""Replay a recorded drone flight as a waypoint mission and measure how close it came."""

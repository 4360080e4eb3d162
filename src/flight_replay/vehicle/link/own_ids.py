"""Whom this program is in a MAVLink network."""

from __future__ import annotations

OUR_SYSTEM = 255
"""ArduPilot obeys, and counts as present, the ground station of SYSID_MYGCS, 255 unless changed."""
OUR_COMPONENT = 25
"""MAV_COMP_ID_USER1: unlike 190 and 230, not what ground stations on the same link use."""

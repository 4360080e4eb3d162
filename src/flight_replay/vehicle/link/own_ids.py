"""The system and component id of this program in a MAVLink network."""

from __future__ import annotations

OUR_SYSTEM = 255
"""ArduPilot obeys the ground station of SYSID_MYGCS, 255 by default, and counts its heartbeats."""
OUR_COMPONENT = 25
"""MAV_COMP_ID_USER1: ground stations on the same link use 190 or 230."""

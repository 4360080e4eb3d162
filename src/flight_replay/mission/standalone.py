"""A mission that flies by itself in AUTO: take-off first, return to launch last.

What is uploaded for a replay has neither: the replay takes off in GUIDED before, and commands RTL
after it, whatever becomes of the mission.
"""

from __future__ import annotations

from dataclasses import replace

from flight_replay.mission.items import WAIT_HERE, Command, Frame, Home, Mission, MissionItem


def standalone(mission: Mission, takeoff_m: float) -> Mission:
    """The mission between a take-off and a return to launch.

    ArduCopter climbs where it stands, whatever place the item names; QGroundControl draws it at that
    place, which is home, or else the first waypoint.

    Args:
        mission: At least one waypoint.
        takeoff_m: How high to climb, metres above home.
    """
    first = mission.waypoints[0][1]
    home = mission.home or Home(first.lat_deg, first.lon_deg, 0.0)
    takeoff = MissionItem(
        Command.TAKEOFF, Frame.RELATIVE, (0.0, 0.0, 0.0, 0.0), home.lat_deg, home.lon_deg, takeoff_m
    )
    come_home = MissionItem(Command.RETURN_TO_LAUNCH, Frame.MISSION, (0.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    # After a take-off a speed change holds (ModeAuto::wp_start); stations draw a wait at its place, 0, 0.
    items = mission.items[1:] if mission.items[0] == WAIT_HERE else mission.items
    return replace(mission, items=(takeoff, *items, come_home))

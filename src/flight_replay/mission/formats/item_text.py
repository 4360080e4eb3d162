"""Mission items in words, and their altitudes above mean sea level, for formats that know no MAVLink."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.logs.track import Track
from flight_replay.mission.items import FIRST_SEQ, Command, Frame, Home, Mission, MissionItem
from flight_replay.mission.path import destinations, path_through

CURVE_TOLERANCE_M = 0.1
"""How far the lines that stand for a spline leg may lie from it: that is not seen on a map."""
_NAMES: dict[int, str] = {command: command.name.lower().replace("_", " ") for command in Command}
_ALTITUDE_FRAMES: dict[int, str] = {
    Frame.ABSOLUTE: "above mean sea level",
    Frame.RELATIVE: "above home",
    Frame.TERRAIN: "above terrain",
}


def command_name(item: MissionItem) -> str:
    """What the item does: "waypoint", "spline waypoint", or its MAV_CMD number where it has no word here."""
    return _NAMES.get(item.command, f"command {item.command}")


def description(item: MissionItem) -> str:
    """A waypoint in one line: how it is flown to, how high, how long it is held."""
    frame = _ALTITUDE_FRAMES.get(item.frame, f"in frame {item.frame}")
    hold = f", hold {item.hold_s:g} s" if item.hold_s > 0 else ""
    return f"{command_name(item)}, {round(item.alt_m, 1) + 0.0:g} m {frame}{hold}"


def amsl_m(item: MissionItem, home: Home | None) -> float:
    """The item's altitude above mean sea level; not a number where home or the terrain is not known."""
    if item.frame == Frame.ABSOLUTE:
        return item.alt_m
    if item.frame == Frame.RELATIVE and home is not None:
        return home.amsl_m + item.alt_m
    return math.nan


def speeds_m_s(mission: Mission) -> dict[int, float]:
    """Speed asked for on the leg to each waypoint, by sequence number; none where none was asked."""
    speeds: dict[int, float] = {}
    asked = math.nan
    for seq, item in enumerate(mission.items, FIRST_SEQ):
        if item.ground_speed_m_s is not None:
            asked = item.ground_speed_m_s
        elif item.is_waypoint and math.isfinite(asked):
            speeds[seq] = asked
    return speeds


def route_line(mission: Mission) -> tuple[Floats, bool]:
    """The planned path as rows (latitude, longitude, altitude), and whether altitudes are above sea.

    Spline legs are drawn as the curves that ArduCopter flies. Where the altitude above mean sea level
    is not known for every waypoint, altitudes are the items' own.
    """
    waypoints = [item for _, item in mission.waypoints]
    if not waypoints:
        return np.zeros((0, 3)), False
    above_sea = all(math.isfinite(amsl_m(item, mission.home)) for item in waypoints)
    items = [_with_amsl(item, mission.home) if above_sea else item for item in mission.items]
    frame = LocalFrame(waypoints[0].lat_deg, waypoints[0].lon_deg)
    line = path_through(destinations(items, frame), tolerance_m=CURVE_TOLERANCE_M)
    rows = np.column_stack([*frame.to_degrees(line.north_east_m), line.up_m])
    moved = np.append(True, np.any(np.diff(rows, axis=0) != 0, axis=1))
    return rows[moved], above_sea


def _with_amsl(item: MissionItem, home: Home | None) -> MissionItem:
    """A waypoint with its altitude above mean sea level; altitude 0 stays, for it means "as before"."""
    if not item.is_waypoint or item.alt_m == 0:
        return item
    return replace(item, alt_m=amsl_m(item, home))


def utc_texts(track: Track, start_utc_s: float) -> list[str]:
    """When each fix was recorded, such as 2023-11-14T22:14:02.250Z, by the Unix time of the first one."""
    times_ms = np.round((track.time_s - track.time_s[0] + start_utc_s) * 1e3).astype("datetime64[ms]")
    return [f"{time}Z" for time in np.datetime_as_string(times_ms)]

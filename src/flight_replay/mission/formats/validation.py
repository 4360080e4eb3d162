"""Checks of a mission item's numbers for every format: that they can be sent and flown."""

from __future__ import annotations

import math
from dataclasses import replace

from flight_replay.exceptions import MissionError
from flight_replay.mission.items import Home, Mission, MissionItem

MAX_ITEMS = 0xFFFE
"""With home, MAVLink counts no more (MISSION_COUNT)."""
_MAX_COMMAND = 0xFFFF
_MAX_FRAME = 0xFF
_MAX_FLOAT32 = 3.4028234e38
_MAX_ANGLE_DEG = 214.0  # In 32 bits, degrees times 1e7; other commands may use these fields as they like.


def finite(number: float) -> float:
    """The number, or 0 where it is infinite or not a number."""
    return number if math.isfinite(number) else 0.0


def checked_item(item: MissionItem, where: str, *, home: bool = False) -> MissionItem:
    """The item, if MAVLink can express it and a waypoint or home has valid coordinates.

    Unknown coordinates of other commands become 0, which ArduCopter takes them for.

    Raises:
        MissionError: A number is out of range.
    """
    _check_range(where, "command", item.command, 0, _MAX_COMMAND)
    _check_range(where, "frame", item.frame, 0, _MAX_FRAME)
    for number, param in enumerate(item.params, 1):
        _check_range(where, f"param{number}", param, -_MAX_FLOAT32, _MAX_FLOAT32)
    _check_range(where, "altitude", item.alt_m, -_MAX_FLOAT32, _MAX_FLOAT32)
    if home or item.is_waypoint:
        _check_coordinates(where, item.lat_deg, item.lon_deg, item.alt_m)
        return item
    for name, angle_deg in (("latitude", item.lat_deg), ("longitude", item.lon_deg)):
        _check_range(where, name, angle_deg, -_MAX_ANGLE_DEG, _MAX_ANGLE_DEG)
    if math.isnan(item.lat_deg) or math.isnan(item.lon_deg):
        return replace(item, lat_deg=finite(item.lat_deg), lon_deg=finite(item.lon_deg))
    return item


def checked_home(home: Home, where: str) -> Home:
    """The home, if its coordinates are valid.

    Raises:
        MissionError: They are not.
    """
    _check_range(where, "altitude", home.amsl_m, -_MAX_FLOAT32, _MAX_FLOAT32)
    _check_coordinates(where, home.lat_deg, home.lon_deg, home.amsl_m)
    return home


def checked_length(mission: Mission, where: str) -> Mission:
    """The mission, if MAVLink can count its items.

    Raises:
        MissionError: It has too many.
    """
    if len(mission.items) > MAX_ITEMS:
        raise MissionError(
            f"{where} has {len(mission.items)} items, more than the {MAX_ITEMS} that MAVLink can count; "
            "split it"
        )
    return mission


def _check_range(where: str, name: str, value: float, lowest: float, highest: float) -> None:
    """Raise if a number is out of range; NaN, which says that a parameter is not used, is not."""
    if value < lowest or value > highest:
        raise MissionError(
            f"{where} has {name} {value:g}, not between {lowest:g} and {highest:g}; correct that item"
        )


def _check_coordinates(where: str, lat_deg: float, lon_deg: float, alt_m: float) -> None:
    if not (abs(lat_deg) <= 90 and abs(lon_deg) <= 180 and math.isfinite(alt_m)):
        coordinates = f"{lat_deg}, {lon_deg}, {alt_m} m"
        raise MissionError(f"{where} has invalid coordinates ({coordinates}); correct that item")

"""What every format asks of a mission item's numbers."""

from __future__ import annotations

import math

from flight_replay.errors import MissionError
from flight_replay.mission.items import MissionItem


def finite(number: float) -> float:
    """The number, or 0 where it is none."""
    return number if math.isfinite(number) else 0.0


def checked_place(item: MissionItem, where: str, *, home: bool = False) -> MissionItem:
    """The item, once it is sure that a place on it is a place on earth.

    Raises:
        MissionError: A waypoint or home lies nowhere; other commands use these fields as they like.
    """
    if not (home or item.is_waypoint):
        return item
    on_earth = abs(item.lat_deg) <= 90 and abs(item.lon_deg) <= 180 and math.isfinite(item.alt_m)
    if not on_earth:
        place = f"{item.lat_deg}, {item.lon_deg}, {item.alt_m} m"
        raise MissionError(f"{where} names no place on earth ({place}); mend that item")
    return item

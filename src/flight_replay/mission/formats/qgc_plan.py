"""QGroundControl's .plan file (QGroundControl developer guide, "Plan File Format").

JSON, version 1 with mission version 2. Home is not an item; a parameter that is not a number is
null. QGroundControl asks for a home in every plan: where none is known, it is at the first waypoint, and
where its height is not, at 0.
"""

from __future__ import annotations

import json
import math
from typing import Any

from flight_replay.exceptions import MissionError
from flight_replay.logs.track import Track
from flight_replay.mission.formats.validation import checked_home, checked_item, finite
from flight_replay.mission.items import FIRST_SEQ, Frame, Home, Mission, MissionItem

_ARDUPILOT = 3  # MAV_AUTOPILOT_ARDUPILOTMEGA
_QUADROTOR = 2  # MAV_TYPE_QUADROTOR
# ArduCopter's own speed when a mission sets none (WPNAV_SPEED since 4.1), and QGroundControl's for planes.
_HOVER_SPEED_M_S = 10.0
_CRUISE_SPEED_M_S = 15.0
# QGroundControl's altitude modes: 1 above home, 2 above mean sea level, 4 above terrain.
_ALTITUDE_MODES: dict[int, int] = {Frame.RELATIVE: 1, Frame.ABSOLUTE: 2, Frame.TERRAIN: 4}


def text(mission: Mission, track: Track | None = None, start_utc_s: float | None = None) -> str:
    """The mission for QGroundControl; this format holds no track."""
    home = mission.home or _home_at_first_waypoint(mission)
    plan = {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "flight-replay",
        "mission": {
            "version": 2,
            "firmwareType": _ARDUPILOT,
            "vehicleType": _QUADROTOR,
            "cruiseSpeed": _CRUISE_SPEED_M_S,
            "hoverSpeed": _first_speed_m_s(mission),
            "globalPlanAltitudeMode": _ALTITUDE_MODES[Frame.RELATIVE],
            "plannedHomePosition": [home.lat_deg, home.lon_deg, home.alt_amsl_m or 0.0],
            "items": [_simple_item(seq, item) for seq, item in enumerate(mission.items, FIRST_SEQ)],
        },
        "geoFence": {"version": 2, "circles": [], "polygons": []},
        "rallyPoints": {"version": 2, "points": []},
    }
    return json.dumps(plan, indent=2, allow_nan=False) + "\n"


def _home_at_first_waypoint(mission: Mission) -> Home:
    for _, item in mission.waypoints:
        return Home(item.lat_deg, item.lon_deg, 0.0)
    return Home(0.0, 0.0, 0.0)


def _first_speed_m_s(mission: Mission) -> float:
    speeds = (item.ground_speed_m_s for item in mission.items)
    return next((speed for speed in speeds if speed is not None), _HOVER_SPEED_M_S)


def _simple_item(seq: int, item: MissionItem) -> dict[str, Any]:
    numbers = (*item.params, item.lat_deg, item.lon_deg, item.alt_m)
    simple: dict[str, Any] = {
        "type": "SimpleItem",
        "autoContinue": True,
        "command": int(item.command),
        "doJumpId": seq,
        "frame": int(item.frame),
        "params": [number if math.isfinite(number) else None for number in numbers],
    }
    mode = _ALTITUDE_MODES.get(item.frame)
    if mode is not None:
        simple |= {"Altitude": finite(item.alt_m), "AltitudeMode": mode, "AMSLAltAboveTerrain": None}
    return simple


def parse(content: str, name: str) -> Mission:
    """The mission in a file's text; errors name the file ``name``.

    Raises:
        MissionError: It is no plan, or has a pattern (a survey, say) instead of single items.
    """
    try:
        mission = json.loads(content)["mission"]
        home = _home(mission["plannedHomePosition"])
        rows = list(mission["items"])
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
        raise MissionError(
            f"{name} is not a QGroundControl plan ({error!r}); save it again in QGroundControl"
        ) from error
    items = tuple(_item(row, f"{name} item {number}") for number, row in enumerate(rows, 1))
    return Mission(items, checked_home(home, f"{name} plannedHomePosition"))


def _home(position: list[float]) -> Home:
    lat_deg, lon_deg, alt_amsl_m = (float(number) for number in position)
    return Home(lat_deg, lon_deg, alt_amsl_m)


def _item(row: Any, where: str) -> MissionItem:
    try:
        if row["type"] != "SimpleItem":
            kind = row.get("complexItemType", row["type"])
            raise MissionError(f"{where} is a {kind} pattern; convert it to single waypoints first")
        p1, p2, p3, p4, lat_deg, lon_deg, alt_m = (
            math.nan if number is None else float(number) for number in row["params"]
        )
        item = MissionItem(int(row["command"]), int(row["frame"]), (p1, p2, p3, p4), lat_deg, lon_deg, alt_m)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise MissionError(
            f"{where} is not a SimpleItem of seven numbers ({error!r}); save it again in QGroundControl"
        ) from error
    return checked_item(item, where)

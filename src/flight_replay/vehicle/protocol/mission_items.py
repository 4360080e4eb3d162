"""Mission items to MAVLink and back, and whether what is on board is what was sent.

MISSION_ITEM_INT carries degrees times 1e7 (1.1 cm); MISSION_ITEM float32 degrees, 0.4 m apart at
35 degrees, for firmware that knows no other (ArduCopter 3.3).
"""

from __future__ import annotations

import math

import numpy as np

from flight_replay.mavlink import Message, dialect
from flight_replay.mission.items import Command, Frame, Home, MissionItem
from flight_replay.vehicle.link.port import Port

_E7 = 1e7
_ALTITUDE_STEP_M = 0.0101  # ArduPilot keeps whole centimetres (AP_Mission's Location) ...
_SPEED_STEP = 0.0101  # ... speeds as float or in cm/s ...
_WHOLE = 0.999  # ... and holds, turns and angles as whole numbers, cut off.

# What ArduCopter keeps of param1 to param4 (AP_Mission::mavlink_int_to_mission_cmd), and how finely.
_KEPT: dict[int, dict[int, float]] = {
    Command.WAYPOINT: {0: _WHOLE},
    Command.SPLINE_WAYPOINT: {0: _WHOLE},
    Command.LOITER_TIME: {0: _WHOLE},
    Command.LOITER_TURNS: {0: _WHOLE},
    Command.DELAY: {0: _WHOLE},
    Command.CHANGE_SPEED: {1: _SPEED_STEP},
}
_PLACELESS = frozenset({Command.RETURN_TO_LAUNCH, Command.DELAY, Command.CHANGE_SPEED})


def item_message(port: Port, seq: int, item: MissionItem, *, as_int: bool) -> Message:
    """The message that carries an item."""
    head = (port.system, port.component, seq, item.frame, item.command, 0, 1, *item.params)
    if as_int:
        place = round(item.lat_deg * _E7), _e7_longitude(item.lon_deg), item.alt_m
        return dialect.MAVLink_mission_item_int_message(*head, *place)
    return dialect.MAVLink_mission_item_message(*head, item.lat_deg, item.lon_deg, item.alt_m)


def _e7_longitude(lon_deg: float) -> int:
    """Longitude times 1e7, between -180 and 180 degrees: 32 bits hold no 220."""
    return round((math.remainder(lon_deg, 360.0) if abs(lon_deg) > 180.0 else lon_deg) * _E7)


def item_of(message: Message) -> MissionItem:
    """The item that a MISSION_ITEM or MISSION_ITEM_INT carries."""
    scale = _E7 if message.get_type() == "MISSION_ITEM_INT" else 1.0
    return MissionItem(
        message.command,
        message.frame,
        (message.param1, message.param2, message.param3, message.param4),
        message.x / scale,
        message.y / scale,
        message.z,
    )


def home_item(home: Home) -> MissionItem:
    """The item of home's slot, number 0; ArduPilot keeps its own home there."""
    place = home.lat_deg, home.lon_deg, home.alt_amsl_m
    return MissionItem(Command.WAYPOINT, Frame.ABSOLUTE, (0.0, 0.0, 0.0, 0.0), *place)


def difference(sent: MissionItem, found: MissionItem, *, as_int: bool) -> str | None:
    """What of an item on board is not what was sent, or None if ArduPilot flies it as sent."""
    if found.command != sent.command:
        return f"command {found.command} instead of {sent.command}"
    for index, step in _KEPT.get(sent.command, {}).items():
        if not abs(found.params[index] - sent.params[index]) <= step:  # Neither is a NaN what was sent.
            return f"param{index + 1} {found.params[index]:g} instead of {sent.params[index]:g}"
    return None if sent.command in _PLACELESS else _place_difference(sent, found, as_int)


def _place_difference(sent: MissionItem, found: MissionItem, as_int: bool) -> str | None:
    if found.frame != sent.frame:
        return f"frame {found.frame} instead of {sent.frame}"
    north = abs(found.lat_deg - sent.lat_deg)
    east = abs(math.remainder(found.lon_deg - sent.lon_deg, 360.0))
    if not (north <= _step_deg(sent.lat_deg, as_int) and east <= _step_deg(sent.lon_deg, as_int)):
        there, wanted = (f"{item.lat_deg:.7f}, {item.lon_deg:.7f}" for item in (found, sent))
        return f"position {there} instead of {wanted}"
    if not abs(found.alt_m - sent.alt_m) <= _ALTITUDE_STEP_M:
        return f"altitude {found.alt_m:g} m instead of {sent.alt_m:g} m"
    return None


def _step_deg(degrees: float, as_int: bool) -> float:
    """How far off a place may come back: floats are rounded on the way out, on board, and on the way back."""
    if as_int:
        return 1.1e-7
    return 2.5 * float(np.spacing(np.float32(abs(degrees)))) + 1.1e-7

"""Mission items to MAVLink and back, and the difference between an item sent and one on board.

MISSION_ITEM_INT holds degrees times 1e7 (1.1 cm); MISSION_ITEM holds degrees as float32, which are
0.4 m apart at 35 degrees, for firmware that knows no other message (ArduCopter 3.3).
"""

from __future__ import annotations

import math

import numpy as np

from flight_replay.mavlink import Message, dialect
from flight_replay.mission.items import Command, MissionItem
from flight_replay.vehicle.link.vehicle_link import VehicleLink

_E7 = 1e7
_ALTITUDE_STEP_M = 0.0101  # ArduPilot stores whole centimetres (AP_Mission's Location) ...
_SPEED_STEP_M_S = 0.0101  # ... speeds as float or in cm/s ...
_WHOLE = 0.999  # ... and holds, turns and angles as whole numbers, truncated.
_FLOAT32 = 0.001  # Headings to 360 degrees, rates and delays are stored as float32.

# The resolution of those of param1 to param4 that are stored (AP_Mission::mavlink_int_to_mission_cmd).
_STORED_STEPS: dict[int, dict[int, float]] = {
    Command.WAYPOINT: {0: _WHOLE},
    Command.SPLINE_WAYPOINT: {0: _WHOLE},
    Command.LOITER_TIME: {0: _WHOLE},
    Command.LOITER_TURNS: {0: _WHOLE},
    Command.DELAY: {0: _WHOLE},
    Command.CHANGE_SPEED: {1: _SPEED_STEP_M_S},
    Command.CONDITION_DELAY: {0: _FLOAT32},
    Command.CONDITION_YAW: {0: _FLOAT32, 1: _FLOAT32, 2: _FLOAT32, 3: _FLOAT32},
}
_WITHOUT_POSITION = frozenset(
    {
        Command.RETURN_TO_LAUNCH,
        Command.DELAY,
        Command.CHANGE_SPEED,
        Command.CONDITION_DELAY,
        Command.CONDITION_YAW,
    }
)


def item_message(link: VehicleLink, seq: int, item: MissionItem, *, as_int: bool) -> Message:
    """The MISSION_ITEM_INT or MISSION_ITEM of an item."""
    head = (link.system, link.component, seq, item.frame, item.command, 0, 1, *item.params)
    if as_int:
        position = round(item.lat_deg * _E7), _e7_longitude(item.lon_deg), item.alt_m
        return dialect.MAVLink_mission_item_int_message(*head, *position)
    return dialect.MAVLink_mission_item_message(*head, item.lat_deg, item.lon_deg, item.alt_m)


def _e7_longitude(lon_deg: float) -> int:
    """Longitude times 1e7, wrapped to -180 to 180 degrees: 220 degrees do not fit into 32 bits."""
    return round((math.remainder(lon_deg, 360.0) if abs(lon_deg) > 180.0 else lon_deg) * _E7)


def item_from(message: Message) -> MissionItem:
    """The item of a MISSION_ITEM or MISSION_ITEM_INT."""
    scale = _E7 if message.get_type() == "MISSION_ITEM_INT" else 1.0
    return MissionItem(
        message.command,
        message.frame,
        (message.param1, message.param2, message.param3, message.param4),
        message.x / scale,
        message.y / scale,
        message.z,
    )


def difference(sent: MissionItem, found: MissionItem, *, as_int: bool) -> str | None:
    """How an item on board differs from the one sent; None if ArduPilot flies it as sent."""
    if found.command != sent.command:
        return f"command {found.command} instead of {sent.command}"
    for index, step in _STORED_STEPS.get(sent.command, {}).items():
        if not abs(found.params[index] - sent.params[index]) <= step:  # True for NaN too.
            return f"param{index + 1} {found.params[index]:g} instead of {sent.params[index]:g}"
    return None if sent.command in _WITHOUT_POSITION else _position_difference(sent, found, as_int)


def _position_difference(sent: MissionItem, found: MissionItem, as_int: bool) -> str | None:
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
    """Tolerance of a coordinate: float32 is rounded when it is sent, stored, and sent back."""
    if as_int:
        return 1.1e-7
    return 2.5 * float(np.spacing(np.float32(abs(degrees)))) + 1.1e-7

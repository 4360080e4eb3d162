"""Mission items as ArduCopter 4.6 stores them: 15 bytes each, so that some of what is sent is lost.

Latitude and longitude are kept to 1e-7 degree, the altitude to the centimetre, and of the parameters
what the command has room for (AP_Mission: mavlink_int_to_mission_cmd and its inverse). What a
ground station reads back is therefore what will be flown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.mission.stored_params import (
    PARAM_RULES,
    STORED_IN_LOCATION,
    float32,
    stored_altitude_cm,
    stored_params,
)

ALTITUDE_LIMIT_M = 83000.0
"""What fits ArduPilot's 24 bits of centimetres (LOCATION_ALT_MAX_M)."""


_METRES_PER_CM = float32(0.01)
_STORED_FRAME = {0: 0, 2: 0, 5: 0, 3: 3, 6: 3, 10: 10, 11: 10}
_MAY_BE_NAN = {16: {4}, 21: {4}, 22: {4}, 84: {4}, 85: {3, 4}}


class ItemRejected(Exception):  # noqa: N818
    """An item that the autopilot rejects, with the MAV_MISSION_RESULT that it answers."""

    def __init__(self, result: int) -> None:
        super().__init__(dialect.enums["MAV_MISSION_RESULT"][result].name)
        self.result = result


@dataclass(frozen=True, slots=True)
class StoredItem:
    """An item on board: degrees times 1e7, centimetres, and ``params`` as they are read back."""

    command: int
    frame: int = 0
    params: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    lat_e7: int = 0
    lon_e7: int = 0
    alt_cm: int = 0

    @property
    def alt_m(self) -> float:
        """Altitude in the item's frame, as 32-bit floats give it."""
        return float32(self.alt_cm * _METRES_PER_CM)


def to_stored_item(message: Message) -> StoredItem:
    """A MISSION_ITEM or MISSION_ITEM_INT as it is stored.

    Raises:
        ItemRejected: for commands, frames and values that ArduCopter rejects.
    """
    x, y = _lat_lon_e7(message)
    params = (message.param1, message.param2, message.param3, message.param4)
    _check_params(message.command, params)
    if message.command in (0, 1):
        raise ItemRejected(dialect.MAV_MISSION_INVALID)
    if message.command not in PARAM_RULES:
        raise ItemRejected(dialect.MAV_MISSION_UNSUPPORTED)
    if message.command not in STORED_IN_LOCATION:
        return StoredItem(message.command, 0, stored_params(message.command, params))
    _check_location(x, y, message.z)
    frame = _STORED_FRAME.get(message.frame)
    if frame is None:
        raise ItemRejected(dialect.MAV_MISSION_UNSUPPORTED_FRAME)
    return StoredItem(
        message.command, frame, stored_params(message.command, params), x, y, stored_altitude_cm(message.z)
    )


def _lat_lon_e7(message: Message) -> tuple[int, int]:
    """Degrees times 1e7; those of a MISSION_ITEM are multiplied as 32-bit floats, as on board."""
    if (
        message.get_msgId() == dialect.MAVLINK_MSG_ID_MISSION_ITEM_INT
        or message.command not in STORED_IN_LOCATION
    ):
        return _whole(message.x), _whole(message.y)
    if not abs(message.x) <= 90:
        raise ItemRejected(dialect.MAV_MISSION_INVALID_PARAM5_X)
    if not abs(message.y) <= 180:
        raise ItemRejected(dialect.MAV_MISSION_INVALID_PARAM6_Y)
    return int(float32(message.x * 1e7)), int(float32(message.y * 1e7))


def _whole(value: float) -> int:
    """A whole number; commands without a location may have anything here, NaN too."""
    return int(value) if math.isfinite(value) else 0


def _check_params(command: int, params: tuple[float, ...]) -> None:
    may_be_nan = _MAY_BE_NAN.get(command, set())
    for number, value in enumerate(params, 1):
        if math.isinf(value) or (math.isnan(value) and number not in may_be_nan):
            raise ItemRejected(dialect.MAV_MISSION_INVALID_PARAM1 + number - 1)


def _check_location(lat_e7: int, lon_e7: int, alt_m: float) -> None:
    if abs(lat_e7) > 90 * 10**7:
        raise ItemRejected(dialect.MAV_MISSION_INVALID_PARAM5_X)
    if abs(lon_e7) > 180 * 10**7:
        raise ItemRejected(dialect.MAV_MISSION_INVALID_PARAM6_Y)
    if math.isnan(alt_m) or abs(alt_m) >= ALTITUDE_LIMIT_M:
        raise ItemRejected(dialect.MAV_MISSION_INVALID_PARAM7)


def item_int(item: StoredItem, seq: int, *, current: bool, system: int, component: int) -> Message:
    """The item as MISSION_ITEM_INT, addressed to the station that asked."""
    return dialect.MAVLink_mission_item_int_message(
        system, component, seq, item.frame, item.command, int(current), 1, *item.params,
        item.lat_e7, item.lon_e7, item.alt_m,
    )  # fmt: skip


def item_float(item: StoredItem, seq: int, *, current: bool, system: int, component: int) -> Message:
    """The item as MISSION_ITEM, its degrees rounded to 32-bit floats as ArduPilot computes them."""
    scale = float32(1e-7)
    lat, lon = (float32(float32(value) * scale) for value in (item.lat_e7, item.lon_e7))
    return dialect.MAVLink_mission_item_message(
        system, component, seq, item.frame, item.command, int(current), 1, *item.params,
        lat, lon, item.alt_m,
    )  # fmt: skip

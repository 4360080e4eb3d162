"""What ArduCopter 4.6 stores of each mission command's four parameters (AP_Mission.h, AP_Mission.cpp).

A command that is not in PARAM_RULES is answered with MAV_MISSION_UNSUPPORTED.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

Rule = Callable[[float], float]


def _integer(low: int, high: int) -> Rule:
    return lambda value: float(min(max(int(value), low), high))


def _not_stored(value: float) -> float:
    return 0.0


def float32(value: float) -> float:
    """The nearest 32-bit float, which is what the autopilot computes with."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def stored_altitude_cm(alt_m: float) -> int:
    """The altitude of an item as it is kept: cut off to a whole centimetre (mavlink_int_to_mission_cmd)."""
    return int(float32(float32(alt_m) * 100.0))


def _flag(value: float) -> float:
    return float(value > 0)


def _direction(value: float) -> float:
    return -1.0 if value < 0 else 1.0


def _turns(value: float) -> float:
    return int(value * 256) / 256 if 0 < value < 1 else float(min(int(value), 255))


def _circle_radius(value: float) -> float:
    size = abs(value)
    metres = float(int(size)) if size <= 255 else min(255, int(size * 0.1)) * 10.0
    return -metres if value < 0 else metres


_U8, _U16 = _integer(0, 2**8 - 1), _integer(0, 2**16 - 1)
_I8, _I16 = _integer(-(2**7), 2**7 - 1), _integer(-(2**15), 2**15 - 1)


def _rules(*rules: Rule) -> tuple[Rule, ...]:
    return rules + (_not_stored,) * (4 - len(rules))


PARAM_RULES: dict[int, tuple[Rule, ...]] = {
    16: _rules(_U16),  # NAV_WAYPOINT: delay, s
    17: _rules(_not_stored, _not_stored, _integer(-(2**16) + 1, 2**16 - 1)),  # NAV_LOITER_UNLIM: radius, m
    18: _rules(_turns, _not_stored, _circle_radius, _flag),  # NAV_LOITER_TURNS
    19: _rules(_U16, _not_stored, _direction, _flag),  # NAV_LOITER_TIME: s
    20: _rules(),  # NAV_RETURN_TO_LAUNCH
    21: _rules(_U16, _not_stored, _not_stored, _direction),  # NAV_LAND
    22: _rules(_U16),  # NAV_TAKEOFF
    30: _rules(_U16),  # NAV_CONTINUE_AND_CHANGE_ALT
    31: _rules(_not_stored, _integer(-(2**16) + 1, 2**16 - 1), _not_stored, _flag),  # NAV_LOITER_TO_ALT
    82: _rules(_U16),  # NAV_SPLINE_WAYPOINT: delay, s
    83: _rules(float32, float32, _U8),  # NAV_ALTITUDE_WAIT
    84: _rules(),  # NAV_VTOL_TAKEOFF
    85: _rules(_U16),  # NAV_VTOL_LAND
    92: _rules(_U16),  # NAV_GUIDED_ENABLE
    93: _rules(float32, _I8, _I8, _I8),  # NAV_DELAY: s, or a time of day
    94: _rules(lambda value: min(max(int(value * 100), 0), 2**16 - 1) / 100),  # NAV_PAYLOAD_PLACE
    112: _rules(float32),  # CONDITION_DELAY
    114: _rules(float32),  # CONDITION_DISTANCE
    115: _rules(float32, float32, _I8, _U8),  # CONDITION_YAW
    177: _rules(_U16, _I16),  # DO_JUMP
    178: _rules(_U8, float32, float32),  # DO_CHANGE_SPEED
    179: _rules(_U16),  # DO_SET_HOME
    181: _rules(_U8, _U8),  # DO_SET_RELAY
    182: _rules(_U8, _I16, float32),  # DO_REPEAT_RELAY
    183: _rules(_U8, _U16),  # DO_SET_SERVO
    184: _rules(_U8, _U16, _I16, float32),  # DO_REPEAT_SERVO
    188: _rules(),  # DO_RETURN_PATH_START
    189: _rules(),  # DO_LAND_START
    191: _rules(),  # DO_GO_AROUND
    193: _rules(_U16),  # DO_PAUSE_CONTINUE
    194: _rules(_U16),  # DO_SET_REVERSE
    201: _rules(_U16),  # DO_SET_ROI
    202: _rules(_U8, _U16, _U8, _U8),  # DO_DIGICAM_CONFIGURE
    203: _rules(_U8, _U8, _I8, _U8),  # DO_DIGICAM_CONTROL
    205: _rules(float32, float32, float32),  # DO_MOUNT_CONTROL
    206: _rules(float32, _not_stored, _U8),  # DO_SET_CAM_TRIGG_DIST
    207: _rules(_U16),  # DO_FENCE_ENABLE
    208: _rules(_U16),  # DO_PARACHUTE
    210: _rules(_U16),  # DO_INVERTED_FLIGHT
    211: _rules(_U8, _U8),  # DO_GRIPPER
    212: _rules(_U16),  # DO_AUTOTUNE_ENABLE
    213: _rules(float32, float32, _U8),  # NAV_SET_YAW_SPEED
    215: _rules(_U16),  # DO_SET_RESUME_REPEAT_DIST
    216: _rules(_U16),  # DO_SPRAYER
    217: _rules(_U16, float32, float32, float32),  # DO_SEND_SCRIPT_MESSAGE
    218: _rules(_U16, _U8),  # DO_AUX_FUNCTION
    222: _rules(_U16, float32, float32, float32),  # DO_GUIDED_LIMITS
    531: _rules(_U8, float32),  # SET_CAMERA_ZOOM
    532: _rules(_U8, float32),  # SET_CAMERA_FOCUS
    534: _rules(_U8, _U8, _U8),  # SET_CAMERA_SOURCE
    600: _rules(_U16),  # JUMP_TAG
    601: _rules(_U16, _I16),  # DO_JUMP_TAG
    1000: _rules(float32, float32, float32, float32),  # DO_GIMBAL_MANAGER_PITCHYAW
    2000: _rules(_U8, float32, _U16, _U16),  # IMAGE_START_CAPTURE
    2001: _rules(_U16),  # IMAGE_STOP_CAPTURE
    2500: _rules(_U8),  # VIDEO_START_CAPTURE
    2501: _rules(_U8),  # VIDEO_STOP_CAPTURE
    42600: _rules(_U8, _U8, float32, float32),  # DO_WINCH
}


def stored_params(
    command: int, params: tuple[float, float, float, float]
) -> tuple[float, float, float, float]:
    """What is stored of the parameters of a command in PARAM_RULES; NaN counts as 0."""
    values = [
        rule(0.0 if math.isnan(value) else value)
        for rule, value in zip(PARAM_RULES[command], params, strict=True)
    ]
    return values[0], values[1], values[2], values[3]


STORED_IN_LOCATION = frozenset({16, 17, 18, 19, 21, 22, 30, 31, 82, 84, 85, 92, 94, 179, 188, 189, 191, 201})
"""Commands stored with latitude, longitude and altitude (AP_Mission::stored_in_location)."""

TAKEOFF_COMMANDS = frozenset({22, 84})
"""Commands that take off."""

"""The parameters that the flight model reads, limited to values with which it can fly.

A station may set any parameter to any value. ArduPilot checks some of them before arming, limits
others where it uses them, and crashes with the rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import cos, radians, sin, sqrt

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.shaping import clamp
from flight_replay.simulator.dynamics.vector import Vector

_SMALLEST = 0.01
_MAX_WIND_M_S = 100.0
_SQUARE_ROOT, _LINEAR = 0, 2  # SIM_WIND_T


def limits_of(parameters: Mapping[str, float]) -> Limits:
    """The flight model's limits; none that it divides by is 0."""
    limits = Limits.from_parameters(parameters)
    return replace(
        limits,
        wp_speed_up_m_s=max(limits.wp_speed_up_m_s, _SMALLEST),
        wp_speed_down_m_s=max(limits.wp_speed_down_m_s, _SMALLEST),
        wp_accel_z_m_s2=max(limits.wp_accel_z_m_s2, _SMALLEST),
        position_p=max(limits.position_p, _SMALLEST),
        position_z_p=max(limits.position_z_p, _SMALLEST),
    )


def wind_m_s(parameters: Mapping[str, float], above_ground_m: float) -> Vector:
    """Velocity of the air at a height, north, east and up; SIM_WIND_DIR is where the wind comes from.

    Source: SIM_Aircraft.cpp (update_wind).
    """
    speed = _wind_speed_m_s(parameters, above_ground_m)
    direction, rise = radians(parameters["SIM_WIND_DIR"]), radians(parameters["SIM_WIND_DIR_Z"])
    level = -speed * cos(rise)
    return level * cos(direction), level * sin(direction), speed * sin(rise)


def _wind_speed_m_s(parameters: Mapping[str, float], above_ground_m: float) -> float:
    """SIM_WIND_SPD, by default weaker near the ground (AP_HAL_SITL/SITL_State.cpp: _simulator_servos)."""
    speed, full_at_m = parameters["SIM_WIND_SPD"], parameters["SIM_WIND_T_ALT"]
    kind = parameters["SIM_WIND_T"]
    if kind == _SQUARE_ROOT and above_ground_m < full_at_m:
        speed *= sqrt(above_ground_m / full_at_m) if above_ground_m > 0 else 0.0
    elif kind == _LINEAR:
        speed += (above_ground_m - full_at_m) * parameters["SIM_WIND_T_COEF"]
    return clamp(speed, 0.0, _MAX_WIND_M_S)

"""Where a vehicle is as its take-off hands over to what it is to fly."""

from __future__ import annotations

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector

_LEFT_M = 0.06
"""The supervisor waits for the climb to end (``supervisor.takeoff_phases``); so much is left after that."""
_LAG_SHARE = 0.8
"""Of what the position controller asks for, which the climb follows behind."""


def after_takeoff(takeoff_m: float, limits: Limits) -> tuple[Vector, Vector]:
    """Its position above home and its velocity, north, east, up, after a take-off to ``takeoff_m``."""
    climb_m_s = min(_LAG_SHARE * limits.position_z_p * _LEFT_M, limits.wp_speed_up_m_s)
    return (0.0, 0.0, takeoff_m - _LEFT_M), (0.0, 0.0, climb_m_s)

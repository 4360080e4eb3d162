"""Thrust and drag of the airframe that ArduPilot's SITL flies, in still or moving air.

Sources: libraries/SITL/SIM_Frame.cpp and SIM_Motor.cpp, default frame "+" of 3 kg.
"""

from __future__ import annotations

from math import cos, pi, sqrt, tan
from typing import Final

from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector

# SIM_Frame.h's default model: at the reference altitude, drag balances 45 degrees of lean at
# 15.08 m/s. A part of it, linear in speed, is the momentum that the rotors give to their air.
_MASS_KG: Final = 3.0
_DISC_AREA_M2: Final = 0.385
_MOMENTUM_DRAG: Final = 0.2
_REFERENCE_SPEED_M_S: Final = 15.08
_REFERENCE_LEAN: Final = pi / 4
_REFERENCE_AMSL_M: Final = 593.0
_HOVER_FORCE_N: Final = _MASS_KG * GRAVITY_M_S2
# Speed of the air below the rotors in hover: twice power (12.09 V, 29.3 A) over force.
_OUTFLOW_M_S: Final = 2.0 * 12.09 * 29.3 / _HOVER_FORCE_N
_TROPOPAUSE_M: Final = 11_000.0


def air_density_kg_m3(amsl_m: float) -> float:
    """Density of the international standard atmosphere; above its lowest layer, that of the layer's top."""
    return 1.225 * float((1.0 - 2.25577e-5 * min(amsl_m, _TROPOPAUSE_M)) ** 4.25588)


def drag_coefficients(amsl_m: float) -> tuple[float, float]:
    """Linear drag, 1/s, and square drag, 1/m, at an altitude (SIM_Frame.cpp: Frame::init)."""
    reference = air_density_kg_m3(_REFERENCE_AMSL_M)
    momentum_n = (
        cos(_REFERENCE_LEAN) ** 2
        * _MOMENTUM_DRAG
        * _REFERENCE_SPEED_M_S
        * sqrt(_HOVER_FORCE_N / cos(_REFERENCE_LEAN) * reference * _DISC_AREA_M2)
    )
    square = (_HOVER_FORCE_N * tan(_REFERENCE_LEAN) - momentum_n) / (_MASS_KG * _REFERENCE_SPEED_M_S**2)
    density = air_density_kg_m3(amsl_m)
    linear = _MOMENTUM_DRAG * sqrt(density * _DISC_AREA_M2 * _HOVER_FORCE_N) / _MASS_KG
    return linear, square * density / reference


class Air(SnapshotPart):
    """The air around home: ``wind_m_s`` is its velocity, north, east, up."""

    __slots__ = ("_linear", "_square", "wind_m_s")

    def __init__(self, wind_m_s: Vector = (0.0, 0.0, 0.0), home_amsl_m: float = 0.0) -> None:
        self.wind_m_s = wind_m_s
        self._linear, self._square = drag_coefficients(home_amsl_m)

    def acceleration(
        self, velocity: Vector, lean: tuple[float, float], heading: tuple[float, float], lift: float
    ) -> Vector:
        """Acceleration by thrust, gravity and drag, north, east, up, m/s².

        Drag is square along each body axis, plus linear in speed and in the root of the thrust.
        Air that flows down through the rotors lessens the thrust (Motor::calc_thrust).

        Args:
            velocity: of the airframe, m/s.
            lean: horizontal part of the thrust over its vertical part, north and east.
            heading: its cosine and sine.
            lift: vertical part of the thrust in still air, m/s².
        """
        wn, we, wu = self.wind_m_s
        n, e, u = velocity[0] - wn, velocity[1] - we, velocity[2] - wu
        tu = 1.0 / sqrt(1.0 + lean[0] * lean[0] + lean[1] * lean[1])
        tn, te = lean[0] * tu, lean[1] * tu
        up = n * tn + e * te + u * tu
        thrust = lift / tu
        if up > 0:
            slowed = up / _OUTFLOW_M_S
            thrust = max(0.0, thrust - GRAVITY_M_S2 * slowed * slowed)
        linear, square = self._linear * sqrt(thrust / GRAVITY_M_S2), self._square
        n, e, u = n - up * tn, e - up * te, u - up * tu
        hn, he = heading
        tilt = hn * tn + he * te
        xn, xe, xu = hn - tilt * tn, he - tilt * te, -tilt * tu
        ahead = (n * xn + e * xe + u * xu) / (xn * xn + xe * xe + xu * xu)
        size = sqrt(xn * xn + xe * xe + xu * xu)
        yn, ye, yu = n - ahead * xn, e - ahead * xe, u - ahead * xu
        side = square * sqrt(yn * yn + ye * ye + yu * yu) + linear
        front = (square * abs(ahead) * size + linear) * ahead
        along = thrust - (square * abs(up) + linear) * up
        return (
            along * tn - front * xn - side * yn,
            along * te - front * xe - side * ye,
            along * tu - front * xu - side * yu - GRAVITY_M_S2,
        )

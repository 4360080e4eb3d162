"""How much the air slows a multicopter down: what thrust has to make up for at speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.simulator.dynamics.aerodynamics import air_density_kg_m3, drag_coefficients

PARAMETER_NAMES = ("EK3_DRAG_BCOEF_X", "EK3_DRAG_BCOEF_Y", "EK3_DRAG_MCOEF")
"""What ArduCopter's estimator knows of the drag, where somebody has measured and set it."""
_LEAST_BCOEF_KG_M2, _LEAST_MCOEF_PER_S = 1.0, 0.001
"""ArduPilot takes values below these for unset (NavEKF3: FuseDragForces)."""


@dataclass(frozen=True, slots=True)
class Drag:
    """Deceleration by the air: ``linear_per_s`` times the speed, and ``square_per_m`` times its square."""

    linear_per_s: float
    square_per_m: float

    def acceleration_m_s2(self, velocity_m_s: Floats) -> Floats:
        """What thrust must make up for (n, 2), along velocities (n, 2)."""
        speed = np.hypot(*velocity_m_s.T)[:, None]
        return np.asarray((self.linear_per_s + self.square_per_m * speed) * velocity_m_s)

    def slope_per_s(self, velocity_m_s: Floats) -> Floats:
        """Derivative (n, 2, 2) of ``acceleration_m_s2`` by velocity."""
        speed = np.hypot(*velocity_m_s.T)
        course = velocity_m_s / np.maximum(speed, 1e-6)[:, None]
        along = (self.square_per_m * speed)[:, None, None] * course[:, :, None] * course[:, None, :]
        linear = (self.linear_per_s + self.square_per_m * speed)[:, None, None]
        return np.asarray(linear * np.eye(2) + along)


@dataclass(frozen=True, slots=True)
class DragModel:
    """Drag by the density of the air.

    Args:
        bcoef_kg_m2: mass over drag area, which gives drag that is square in speed; None for no such drag.
        mcoef_per_s: drag that is linear in speed, at sea level.
    """

    bcoef_kg_m2: float | None
    mcoef_per_s: float

    def at(self, amsl_m: float) -> Drag:
        """Drag at an altitude (EK3_DRAG_BCOEF_X, EK3_DRAG_MCOEF)."""
        density, sea_level = air_density_kg_m3(amsl_m), air_density_kg_m3(0.0)
        square = 0.0 if self.bcoef_kg_m2 is None else 0.5 * density / self.bcoef_kg_m2
        return Drag(self.mcoef_per_s * sqrt(density / sea_level), square)


def drag_model_of(parameters: Mapping[str, float]) -> DragModel | None:
    """The drag that a vehicle's parameters tell; None where they are not set.

    Of the two axes the one with more drag counts: a vehicle may fly to any side.

    Args:
        parameters: those of ``PARAMETER_NAMES`` that the vehicle has.
    """
    bcoefs = [
        value for name in PARAMETER_NAMES[:2] if (value := parameters.get(name, 0.0)) > _LEAST_BCOEF_KG_M2
    ]
    mcoef = parameters.get(PARAMETER_NAMES[2], 0.0)
    mcoef = mcoef if mcoef > _LEAST_MCOEF_PER_S else 0.0
    if not bcoefs and not mcoef:
        return None
    return DragModel(min(bcoefs, default=None), mcoef)


def sitl_drag(amsl_m: float) -> Drag:
    """Drag at an altitude of the quadcopter that ArduPilot's SITL flies unless told otherwise."""
    return Drag(*drag_coefficients(amsl_m))

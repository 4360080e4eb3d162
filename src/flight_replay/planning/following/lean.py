"""How far a multicopter has to lean for a motion: its acceleration, and the drag of the air."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.following.smoothing import Bound, Knots


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


def lean_bound(knots: Knots, drag: Drag, velocity_m_s: Floats, most_m_s2: float) -> Bound:
    """The horizontal thrust per mass is at most ``most_m_s2``, with drag linear around a known motion.

    Args:
        knots: of the motion, which has two axes.
        drag: of the vehicle.
        velocity_m_s: of the known motion at the knots (m, 2).
        most_m_s2: bound of |acceleration + drag|.
    """
    slope = drag.slope_per_s(velocity_m_s)
    offset = drag.acceleration_m_s2(velocity_m_s) - np.einsum("nij,nj->ni", slope, velocity_m_s)
    rate, acceleration = knots.derivative(1), knots.derivative(2)

    def component(axis: int) -> Any:
        blocks = [sparse.diags_array(slope[:, axis, other]) @ rate for other in range(2)]
        blocks[axis] = blocks[axis] + acceleration
        return sparse.hstack(blocks, format="csr")

    return Bound([component(0), component(1)], most_m_s2, offset)

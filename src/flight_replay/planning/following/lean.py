"""How far a multicopter has to lean for a motion: its acceleration, and the drag of the air."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.drag import Drag
from flight_replay.planning.following.smoothing import Bound, Knots


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

"""How far a multicopter has to lean for a motion: its acceleration, and the drag of the air.

Thrust along the way and thrust across it are not worth the same. Near the limit of the lean, what is short
along the way makes a vehicle late; what is short across throws it off the path, the farther the faster it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.drag import Drag
from flight_replay.planning.smoothing import Bound, Knots

_MOVING_M_S = 2.0
"""At this speed the way counts half as a direction: slower vehicles may turn anywhere."""


@dataclass(frozen=True, slots=True)
class MostThrust:
    """The most horizontal thrust per mass along the way, and the most across it, which is no more."""

    along_m_s2: float
    across_m_s2: float


def lean_bound(knots: Knots, drag: Drag, velocity_m_s: Floats, most: MostThrust) -> Bound:
    """The horizontal thrust per mass stays in an ellipse; drag is linear around a known motion.

    Args:
        knots: of the motion, which has two axes.
        drag: of the vehicle.
        velocity_m_s: of the known motion at the knots (m, 2), whose way it is.
        most: the ellipse's half axes; the slower the motion, the more it is a circle of the smaller one.
    """
    slope = drag.slope_per_s(velocity_m_s)
    offset = drag.acceleration_m_s2(velocity_m_s) - np.einsum("nij,nj->ni", slope, velocity_m_s)
    rate, acceleration = knots.derivative(1), knots.derivative(2)

    def component(axis: int) -> Any:
        blocks = [sparse.diags_array(slope[:, axis, other]) @ rate for other in range(2)]
        blocks[axis] = blocks[axis] + acceleration
        return sparse.hstack(blocks, format="csr")

    shorter = _shorter_along(velocity_m_s, most)
    north, east = component(0), component(1)
    rows = [
        sparse.csr_array(
            sparse.diags_array(shorter[:, axis, 0]) @ north + sparse.diags_array(shorter[:, axis, 1]) @ east
        )
        for axis in range(2)
    ]
    return Bound(rows, most.across_m_s2, np.einsum("nij,nj->ni", shorter, offset))


def _shorter_along(velocity_m_s: Floats, most: MostThrust) -> Floats:
    """Matrices (m, 2, 2) that make an ellipse a circle: vectors along the way become shorter."""
    share = 1.0 - most.across_m_s2 / most.along_m_s2
    square = (velocity_m_s**2).sum(axis=1) + _MOVING_M_S**2
    ways = np.einsum("ni,nj->nij", velocity_m_s, velocity_m_s) / square[:, None, None]
    return np.asarray(np.eye(2) - share * ways)

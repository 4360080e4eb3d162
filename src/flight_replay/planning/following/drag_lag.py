"""How far a vehicle is beside its targets because of drag that nothing makes up for.

ArduCopter feeds the acceleration of a target forward, but not the drag at its velocity: that only the
velocity controller's errors make up for, first in proportion, then by its integral. Where the speed has
just changed, the vehicle is off. Targets displaced by that lag put it right.
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.reference_motion import ReferenceMotion, SmoothMotion, motion_through
from flight_replay.planning.drag import Drag
from flight_replay.simulator.dynamics.limits import Limits

_STEP_S = 0.05
_KNOT_STEPS = 5  # 0.25 s, as the reference's.
_MOST_M = (
    4.0  # With the gains of 4.6 it is up to 1.5 m, with those of 3.3 up to 3.5 m: more is not to be trusted.
)


def drag_lag(reference: ReferenceMotion, drag: Drag, limits: Limits) -> SmoothMotion | None:
    """The displacement of targets that makes up for all of a drag, level and bounded; None with absurd gains.

    Args:
        reference: what is followed.
        drag: of the vehicle.
        limits: with the gains of its position and velocity controllers.
    """
    spans = max(int(np.ceil((reference.end_s - reference.begin_s) / (_STEP_S * _KNOT_STEPS))), 4)
    times_s = np.linspace(reference.begin_s, reference.end_s, spans * _KNOT_STEPS + 1)
    drag_m_s2 = drag.acceleration_m_s2(reference.velocities_m_s(times_s)[:, :2])
    with np.errstate(all="ignore"):
        lag_m = _lag_m(drag_m_s2, float(times_s[1] - times_s[0]), limits)[::_KNOT_STEPS]
    if not np.isfinite(lag_m).all():
        return None
    lag_m *= np.minimum(1.0, _MOST_M / np.maximum(np.linalg.norm(lag_m, axis=1, keepdims=True), 1e-9))
    return motion_through(times_s[::_KNOT_STEPS], np.pad(lag_m, ((0, 0), (0, 1))))


def _lag_m(drag_m_s2: Floats, step_s: float, limits: Limits) -> Floats:
    """The lag (n, 2) of a copter for a drag (n, 2), which is constant in each step.

    With x the lag, the position controller adds u = x' + p x to the velocity error, and the velocity
    controller and the feed-forward have to make the drag: x'' + d u' + k u + i integral(u) = drag. The
    state is the integral of x, x and x'.
    """
    from scipy.linalg import expm

    gain = 1.0 + limits.velocity_d
    loop = np.convolve([limits.velocity_d, limits.velocity_p, limits.velocity_i], [1.0, limits.position_p])
    system = np.zeros((4, 4))
    system[0, 1] = system[1, 2] = 1.0
    system[2] = [*(-loop[:0:-1] / gain), 1.0 / gain]
    exact = expm(system * step_s)
    states = np.zeros((len(drag_m_s2), 3, 2))
    for step in range(1, len(states)):
        states[step] = exact[:3, :3] @ states[step - 1] + exact[:3, 3:] * drag_m_s2[step - 1]
    return states[:, 1]
